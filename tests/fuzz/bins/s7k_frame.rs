//! The libFuzzer program for [`backseat_fuzz::s7k_frame`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| backseat_fuzz::s7k_frame(data));
