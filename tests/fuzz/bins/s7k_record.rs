//! The libFuzzer program for [`backseat_fuzz::s7k_record`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| backseat_fuzz::s7k_record(data));
