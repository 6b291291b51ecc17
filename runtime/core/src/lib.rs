//! The backseat state machine: session, control, leases, plan, ledger, assurance; sans-IO and deterministic.

pub mod plugin;
