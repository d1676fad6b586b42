//! The pages in a real Chromium, served by a real train: loading, renewing, acknowledging, outliving the service, charts,
//! readers who use no mouse or no eyes, paper, a long train.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print the figures they measure")]

mod charts;
mod common;
mod faults;
mod languages;
mod living;
mod long;
mod paper;
mod readers;
mod report;
mod settings;

use charts::*;
use faults::*;
use languages::*;
use living::*;
use long::*;
use paper::*;
use readers::*;
use report::*;
use settings::*;

railgrip_requirements::tests! {
    at_once = 1;
    the_pages_load_say_everything_in_words_and_renew_themselves: [CHROMIUM],
    old_data_say_so_loudly_and_an_alert_is_acknowledged_with_the_keyboard: [CHROMIUM],
    the_page_outlives_the_service: [CHROMIUM],
    who_is_not_known_is_led_to_the_login_and_back: [CHROMIUM],
    charts_are_zoomed_compared_shared_and_saved: [CHROMIUM],
    what_is_wrong_comes_first_and_is_answered_from_the_first_screen: [CHROMIUM],
    every_page_is_clean_by_axe_in_both_themes_and_on_the_phone: [CHROMIUM, AXE_CORE],
    an_alert_is_acknowledged_and_taken_back_by_ear_and_keyboard: [CHROMIUM],
    a_wagon_and_the_train_are_one_page_of_a4_each: [CHROMIUM],
    a_gap_report_begins_with_one_page_of_a4_and_fits_a_phone: [CHROMIUM, LABELLED_CASES],
    a_receiver_is_added_changed_and_removed_on_the_page: [CHROMIUM],
    every_page_speaks_german_without_a_word_of_english: [CHROMIUM],
    a_train_of_64_wagons_is_shown_whole_and_costs_no_memory_over_time: [CHROMIUM],
}
