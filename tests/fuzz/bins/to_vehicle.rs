//! The libFuzzer program for [`backseat_fuzz::to_vehicle`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| backseat_fuzz::to_vehicle(data));
