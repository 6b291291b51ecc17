use backseat_core::Grant;
use backseat_core::plugin::Request;

/// A request's kind as the log names it, and the grants that it needs.
pub(crate) fn kind_and_needs(request: &Request) -> (&'static str, Vec<Grant>) {
    let insert = |interrupt: bool| {
        let interrupts = interrupt.then_some(Grant::Interrupt);
        [Grant::Insert].into_iter().chain(interrupts).collect()
    };
    match request {
        Request::Modify(_) => ("modify", vec![Grant::Modify]),
        Request::Trackline(line) => ("trackline", insert(line.interrupt)),
        Request::Trackcircle(circle) => ("trackcircle", insert(circle.interrupt)),
        Request::GpsHit(_) => ("gps-hit", vec![Grant::Surface]),
        Request::Cancel(_) => ("cancel", vec![Grant::Insert]),
        Request::Message(_) => ("message", vec![Grant::Message]),
        Request::Topside(_) => ("topside", vec![Grant::Topside]),
        Request::DvlTrigger(_) => ("dvl-trigger", vec![Grant::Dvl]),
        Request::Silent(_) => ("silent", vec![Grant::Silent]),
        Request::Trim(_) => ("trim", vec![Grant::Trim]),
        Request::Buoyancy(_) => ("buoyancy", vec![Grant::Buoyancy]),
        Request::Packet(_) => ("packet", vec![Grant::Acoustic]),
        Request::Station(_) => ("station", vec![Grant::Station]),
        Request::SonarAngle(_) => ("sonar-angle", vec![Grant::Devices]),
        Request::Camera(_) => ("camera", vec![Grant::Devices]),
        Request::Light(_) => ("light", vec![Grant::Devices]),
        Request::SonarSet(_) => ("sonar-set", vec![Grant::Sonar]),
        Request::SonarLog(_) => ("sonar-log", vec![Grant::Sonar]),
        Request::EndModify => ("end-modify", vec![]),
        Request::EndStation => ("end-station", vec![]),
        Request::Timer { .. } => ("timer", vec![]),
    }
}

/// Whether the runtime keeps account of each request of this kind: it has an outcome, and a place in the log.
pub(crate) fn is_in_the_ledger(kind: &str) -> bool {
    !["message", "end-modify", "end-station", "timer"].contains(&kind)
}
