//! The backseat's state machine: session, control, leases, plan, ledger, assurance; sans-IO and deterministic.
