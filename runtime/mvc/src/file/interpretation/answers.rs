use serde::Deserialize;

/// How the vehicle answers a command whose name it does not know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnknownCommand {
    /// BFACK names `NAK`, and the time `000000.000`, as vehicles in the field do.
    #[default]
    Nak,
    /// BFACK names the command and repeats its time, as SPI 6.21 says of these fields.
    Name,
    /// The seed draws one.
    Seed,
}

/// How the vehicle answers a line that is no sentence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BrokenLine {
    /// Not at all.
    #[default]
    Ignore,
    /// With a BFACK of the name `NAK` for each such line.
    Nak,
    /// The seed draws one.
    Seed,
}

/// What the pressure of BFCTD and BPCTD counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CtdPressure {
    /// A vacuum: the atmosphere's pressure is part of it.
    #[default]
    Absolute,
    /// The atmosphere's pressure: it is 0 at the surface.
    Gauge,
    /// The seed draws one.
    Seed,
}

/// Which messages `BPLOG,ALL` switches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AllTopics {
    /// All but BFACK, as SPI 7.1 says.
    #[default]
    All,
    /// BFNVG, BFNVR and BFACK, as seen of a vehicle in the field.
    Navigation,
    /// The seed draws one.
    Seed,
}
