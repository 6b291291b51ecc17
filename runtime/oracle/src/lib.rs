//! Judges a run from the recorded link bytes and the mock vehicle's truth alone.
