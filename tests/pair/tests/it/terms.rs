//! Each term of the envelope is needed: without it the vehicle leaves.
//!
//! In each test one thing is as bad as the limits allow, and all others are as good as they can be. The mock vehicle
//! flies the closest request that the monitor accepts. Its true position must stay inside the fence or the bound. It
//! must also come closer than the width of the term, so that the test fails if the term is left out. The table has how
//! far the vehicle then leaves the fence:
//!
//! | term | m | test |
//! |---|---|---|
//! | modify: the 5 s after the last word | 4.1 | `the_five_seconds_that_it_obeys_after_the_last_word` |
//! | modify: navigation's age | 2.4 | `the_age_of_navigation` |
//! | modify: the link's delay | 2.3 | `the_delay_of_the_link` |
//! | modify: the current | 4.5 | `the_strongest_current` |
//! | modify: navigation's error | 22.0 | `the_error_of_navigation` |
//! | modify: the turn onto the heading | 3.5 | `the_turn_onto_the_heading` |
//! | modify: the turn away | 15.1 | `the_turn_away` |
//! | modify: the begin and the end of a turn | 1.5 | `a_turn_has_to_begin` |
//! | modify: a plan that is faster than any request | 5.8 | `the_plan_may_be_faster_than_any_request` |
//! | modify: the other north | 0.3 | `the_other_north` |
//! | modify: the ways back | 11.3 | `the_ways_back` |
//! | insert: navigation's error | 8.4 | `the_error_of_navigation_on_a_line` |
//! | insert: the turn's width | 10.8 | `the_width_of_a_turn` |
//! | insert: the current in a turn | 0.3 | `the_current_in_a_turn` |
//! | insert: the lead-in | 32.9 | `the_longest_lead` |
//! | insert: the way to it | 5.0 | `the_way_to_a_line` |
//! | insert: the way on | 10.0 | `the_way_on_from_a_line` |
//! | circle: entered anywhere | 10.0 | `a_circle_that_is_entered_anywhere_is_left_anywhere` |
//! | GPS hit: the drift of the wait | 83.2 | `the_drift_of_the_wait_for_gps` |
//! | GPS hit: the climb | 40 | `a_climb_leads_on_from_the_place` |
//! | GPS hit: the depths on the way | 8.0 | `the_depths_on_the_way_from_the_surface` |
//! | depth: vertical error | 2.3 | `the_error_of_the_depth` |
//! | altitude: vertical error | 0.2 | `the_error_of_the_altitude` |
//! | the bed's slope | 6.4 | `the_slope_of_the_bed` |
//! | the bed's slope, by altitude | 25.3 | `the_slope_of_the_bed_below_an_altitude` |
//! | the age of the bottom lock | 0.05 | `the_age_of_the_bottom_lock` |
//! | station: the 2 s of silence | 0.9 | `the_two_seconds_of_silence_are_the_way_that_it_takes_to_stop` |
//! | station: the age | 0.6 | `the_age_of_relative_navigation` |
//! | station: the link's delay | 0.2 | `the_delay_of_the_link_to_station_keeping` |
//!
//! `figures` checks the values of terms that the mock does not need, because a greater term covers them: the tracking
//! error, the current while a modify is obeyed, the error of relative navigation. Three other checks come before the
//! limit of 2.5 s for a refresh: see `no_refresh_is_later_than_two_and_a_half_seconds`.

mod figures;
mod hover;
mod inserts;
mod modify;
mod scene;
mod vertical;
