use serde::Serialize;

use crate::margin::Margins;

/// How much there was to judge.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Bytes that the vehicle wrote.
    pub bytes_from_vehicle: u64,
    /// Bytes that we wrote.
    pub bytes_to_vehicle: u64,
    /// Whole sentences of ours.
    pub sentences_to_vehicle: u64,
    /// BFNVG whose solution time advanced.
    pub navigations: u64,
    /// How often the link came up.
    pub connections: u64,
    /// How often we received control.
    pub control_spans: u64,
    /// How long we had control, seconds.
    pub control_s: f64,
    /// BPRMB.
    pub modifies: u64,
    /// BPEMB.
    pub end_modifies: u64,
    /// Leases: a BPRMB while none was alive opens one.
    pub leases: u64,
    /// How long leases were alive, by our sentences, seconds.
    pub lease_s: f64,
    /// How often a hovering vehicle kept station: a BPSUS while no suspension was alive begins one.
    pub stations: u64,
    /// How long station keeping was alive, by our sentences, seconds.
    pub station_s: f64,
    /// BPRTK, BPRTC and BPRGP.
    pub inserts_sent: u64,
    /// Of those, refused by the vehicle.
    pub inserts_refused: u64,
    /// Of those, accepted by the vehicle.
    pub inserts_accepted: u64,
    /// Of those, begun.
    pub inserts_begun: u64,
    /// Of those, cancelled before they began.
    pub inserts_cancelled: u64,
    /// Reports of the vehicle's truth.
    pub truths: u64,
    /// How long the vehicle truly flew inserts, seconds.
    pub truth_insert_s: f64,
    /// How long the vehicle truly flew under a modify, seconds.
    pub truth_modified_s: f64,
    /// How often the true position was compared with the fence.
    pub truth_judged: u64,
    /// All violations, including those that the list omits.
    pub violations: u64,
    /// How near the run came to what the requirements forbid.
    pub margins: Margins,
}
