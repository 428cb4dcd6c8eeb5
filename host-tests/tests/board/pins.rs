//! The pin tables of docs/hardware.md and docs/guard-board.md, compared with what the
//! manufacturer's data say about the chips.

use crate::chips::{g431, g474};
use std::fs;
use tautrack_host_tests::programs::setup::checkout;

/// Rows of the table of a page: pin, and the column with its alternate function.
pub fn rows(page: &str) -> Vec<(String, String)> {
    let path = checkout::root()
        .expect("a checkout")
        .join("docs")
        .join(page);
    let page = fs::read_to_string(path).expect("the page");
    let cell = |line: &str, index: usize| {
        line.split('|')
            .nth(index)
            .map(|text| text.trim().to_owned())
    };
    page.lines()
        // A pin is a port and a number.
        .filter(|line| line.starts_with("| P") && line.as_bytes()[4].is_ascii_digit())
        .map(|line| {
            (
                cell(line, 1).expect("a pin"),
                cell(line, 3).expect("a function"),
            )
        })
        .collect()
}

/// Signal and number of an alternate function, `TIM1_CH1 (6)`; `None` for other functions.
pub fn alternate(function: &str) -> Option<(&str, u32)> {
    let (signal, number) = function.strip_suffix(')')?.split_once(" (")?;
    Some((signal, number.parse().expect("a number")))
}

/// Checks the rows of a page. Returns how many have an alternate function.
fn check(page: &str, known: fn(&str, &str) -> Option<u32>) -> usize {
    let mut checked = 0;
    for (pin, function) in rows(page) {
        let Some((signal, number)) = alternate(&function) else {
            assert!(
                ["analogue", "input", "output"].contains(&&*function),
                "{pin}: {function}"
            );
            continue;
        };
        assert_eq!(known(&pin, signal), Some(number), "{pin}: {function}");
        checked += 1;
    }
    checked
}

#[test]
fn every_pin_of_the_pages_has_this_alternate_function_on_the_chip() {
    assert_eq!(check("hardware.md", g431::alternate), 11);
    assert_eq!(check("guard-board.md", g474::alternate), 5);
}

#[test]
fn the_analogue_pins_reach_the_converters_that_the_page_names() {
    for (peripheral, signal, pin) in [
        ("OPAMP1", "VINP0", "PA1"),
        ("OPAMP1", "VINM0", "PA3"),
        ("OPAMP1", "VOUT", "PA2"),
        ("OPAMP2", "VINP0", "PA7"),
        ("OPAMP2", "VINM0", "PA5"),
        ("OPAMP2", "VOUT", "PA6"),
        ("ADC1", "IN3", "PA2"),
        ("ADC2", "IN3", "PA6"),
        ("ADC1", "IN1", "PA0"),
        ("ADC1", "IN5", "PB14"),
        ("OPAMP3", "VINP0", "PB0"),
        ("OPAMP3", "VINM0", "PB2"),
        ("OPAMP3", "VOUT", "PB1"),
        ("ADC1", "IN12", "PB1"),
        ("COMP1", "INP", "PA1"),
        ("COMP2", "INP", "PA7"),
        ("COMP4", "INP", "PB0"),
    ] {
        let pins = g431::pins(peripheral, signal);
        assert!(pins.contains(pin), "{peripheral} {signal}: {pins:?}");
    }
}
