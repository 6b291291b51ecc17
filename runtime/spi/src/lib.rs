//! The Bluefin Standard Payload Interface: framing, typed messages, catalogue.
