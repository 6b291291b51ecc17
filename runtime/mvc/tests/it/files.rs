/// A calm, exact world: flat, no current, perfect sensors. One long dynamic line, then a short one without control.
pub(crate) const CALM: &str = r#"
[start]
utc = 2026-06-01T08:00:00Z
[origin]
latitude_deg = 42.3
longitude_deg = -70.9
[seabed]
depth_m = 60
slope = 0
meanders = 0
[sensors]
position_noise_m = 0
position_drift_m_per_sqrt_h = 0
depth_noise_m = 0
heading_noise_deg = 0
attitude_noise_deg = 0
velocity_noise_mps = 0
altitude_noise_m = 0
altitude_dropouts_per_h = 0
temperature_noise_c = 0
conductivity_noise_us_per_cm = 0
pressure_noise_kpa = 0
temperature_bias_c = 0
conductivity_bias_us_per_cm = 0
pressure_bias_kpa = 0
[sensors.ins]
heading_bias_deg = 0
[sensors.dvl]
scale_error = 0
misalignment_deg = 0
velocity_noise_mps = 0
range_noise_m = 0
beam_loss = 0
temperature_noise_c = 0
[sensors.gps]
error_m = 0
[sensors.compass]
bias_deg = 0
deviation_deg = 0
soft_iron_deg = 0
noise_deg = 0
[sensors.imu]
rate_noise_dps = 0
rate_bias_dph = 0
acceleration_noise_mps2 = 0
acceleration_bias_mps2 = 0
[sensors.depth]
bias_kpa = 0
noise_kpa = 0
[sensors.sound]
noise_mps = 0
bias_mps = 0
[sensors.tailcone]
rpm_noise = 0
speed_error = 0
angle_noise_deg = 0
[mission]
starts_after_s = 1
[spi]
acknowledge = "immediate"
[[plan]]
kind = "trackline"
start = { east_m = 0, north_m = 20 }
end = { east_m = 0, north_m = 400 }
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = "waypoint"
at = { east_m = 100, north_m = 400 }
depth_m = 10
speed_mps = 2
"#;

/// A lively world: slope, meanders, banks, current, plume, noise; every kind of element. The seed draws every
/// interpretation.
pub(crate) const LIVELY: &str = r#"
[start]
utc = 2026-06-01T23:58:30Z
east_m = -50
[origin]
latitude_deg = 42.3
longitude_deg = -66.1
[seabed]
depth_m = [40, 70]
banks = 2
[current]
speed_mps = [0.05, 0.3]
rotation_h = 12.42
[[field.plumes]]
east_m = [-200, 200]
north_m = [-200, 200]
sigma_m = [80, 150]
temperature_c = 3
[vehicle]
class = "9-inch"
[mission]
starts_after_s = 5
wrap_up = "surface"
[spi]
profile = "field"
[interpretation]
inserts_after_control = "seed"
after_interrupt = "seed"
lead_in_m = "seed"
control_replay = "seed"
cancel_all_scope = "seed"
modify_heading = "seed"
adjustment_when_silenced = "seed"
adjustment_needs_status = "seed"
dvl_timeout_announced = "seed"
unacked_frames = "seed"
insert_place = "seed"
insert_logging = "seed"
cancel_scope = "seed"
cancel_all_gps = "seed"
modify_survives = "seed"
modify_beyond = "seed"
modify_fins = "seed"
interruption = "seed"
[[plan]]
kind = "waypoint"
at = { east_m = 0, north_m = 60 }
depth_m = 5
speed_mps = 1.8
[[plan]]
kind = "trackline"
start = { east_m = 0, north_m = 80 }
end = { east_m = 150, north_m = 120 }
altitude_m = 12
speed_mps = 1.8
dynamic = true
[[plan]]
kind = "setpoint"
heading_deg = 180
duration_s = 60
depth_m = 12
speed_mps = 1.5
dynamic = true
[[plan]]
kind = "trackcircle"
centre = { east_m = 100, north_m = 0 }
radius_m = 40
orbits = -1.5
altitude_m = 15
speed_mps = 1.8
dynamic = true
dynamic_from_s = 20
dynamic_for_s = 60
[[plan]]
kind = "waypoint"
at = { east_m = 0, north_m = 0 }
depth_m = 3
speed_mps = 2
"#;
