//! Tests the reader of NMEA sentences against sentences that were written in another way.

use crate::framed;
use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::estimate::nmea::{Gga, Place, Reader, Refusal, Rmc, Sentence};
use tautrack::estimate::position::Fix;

/// Returns what the reader reports for `bytes`.
fn read(reader: &mut Reader, bytes: &[u8]) -> Vec<Result<Sentence, Refusal>> {
    bytes.iter().filter_map(|byte| reader.push(*byte)).collect()
}

fn read_one(body: &str) -> Result<Sentence, Refusal> {
    let found = read(&mut Reader::default(), &framed(body));
    assert_eq!(found.len(), 1, "{body}: {found:?}");
    found[0]
}

#[test]
fn sentences_of_any_talker_give_their_fields_in_integers() {
    // 48 + 7.038/60 degrees, 11 + 31/60 degrees.
    let place = Some(Place {
        latitude: 481_173_000,
        longitude: 115_166_667,
    });
    for talker in ["GP", "GN", "GL", "GA", "GB", "BD"] {
        let gga = format!("{talker}GGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,");
        let expected = Gga {
            time_ms: Some(45_319_000),
            place,
            altitude_mm: Some(545_400),
            quality: 1,
            satellites: Some(8),
            dilution: Some(90),
        };
        assert_eq!(read_one(&gga), Ok(Sentence::Gga(expected)));
        let rmc =
            format!("{talker}RMC,123519.25,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W");
        let expected = Rmc {
            time_ms: Some(45_319_250),
            place,
            // 22.4 knots are 11.5236 m/s.
            speed_mm_s: Some(11_523),
            course: Some(8_440),
        };
        assert_eq!(read_one(&rmc), Ok(Sentence::Rmc(expected)));
    }
    let south_west =
        read_one("GNGGA,000000.001,3351.12345678,S,07039.99999999,W,4,12,0.5,-12.3456,M,,M,,");
    let Ok(Sentence::Gga(gga)) = south_west else {
        panic!("{south_west:?}")
    };
    let place = gga.place.expect("a fix");
    // -(33 + 51.12345678/60), -(70 + 39.99999999/60) degrees.
    assert_eq!(
        (place.latitude, place.longitude),
        (-338_520_576, -706_666_667)
    );
    assert_eq!((gga.time_ms, gga.altitude_mm), (Some(1), Some(-12_346)));
}

#[test]
fn a_receiver_without_a_fix_gives_no_place() {
    let Ok(Sentence::Gga(gga)) = read_one("GPGGA,120000.00,,,,,0,00,99.99,,,,,,") else {
        panic!("a good sentence")
    };
    assert_eq!((gga.quality, gga.place, gga.altitude_mm), (0, None, None));
    let Ok(Sentence::Rmc(rmc)) = read_one("GPRMC,120000.00,V,4807.038,N,01131.000,E,,,010626,,,N")
    else {
        panic!("a good sentence")
    };
    assert_eq!(rmc.place, None);
}

const PLACE: &str = "4807.038,N,01131.000,E";

/// Returns whether the sentence with this body gives a fix.
fn fixes(body: &str) -> bool {
    let found = read(&mut Reader::default(), &framed(body));
    let mut sentences = found.iter().flatten();
    sentences.any(|sentence| Fix::from_sentence(sentence).is_some())
}

/// Body of an RMC sentence that ends in these fields.
fn rmc_with(status: &str, end: &str) -> String {
    format!("GNRMC,123519,{status},{PLACE},022.4,084.4,230394,003.1,W{end}")
}

/// Body of a GGA sentence with this quality.
fn gga_with(quality: &str) -> String {
    format!("GNGGA,123519,{PLACE},{quality},08,0.9,545.4,M,46.9,M,,")
}

#[test]
fn a_position_that_was_not_measured_is_no_fix() {
    for (body, fix) in [
        (gga_with("0"), false),
        (gga_with("1"), true),
        (gga_with("2"), true),
        (gga_with("3"), true),
        (gga_with("4"), true),
        (gga_with("5"), true),
        (gga_with("6"), false),
        (gga_with("7"), false),
        (gga_with("8"), false),
        // Receivers older than version 2.3 of the standard send no mode.
        (rmc_with("A", ""), true),
        (rmc_with("A", ","), true),
        (rmc_with("A", ",A"), true),
        (rmc_with("A", ",D"), true),
        (rmc_with("A", ",F"), true),
        (rmc_with("A", ",P"), true),
        (rmc_with("A", ",R"), true),
        (rmc_with("A", ",E"), false),
        (rmc_with("A", ",M"), false),
        (rmc_with("A", ",S"), false),
        (rmc_with("A", ",N"), false),
        (rmc_with("V", ",A"), false),
        (rmc_with("V", ",N"), false),
        // The status of navigation, which follows the mode, says nothing of the position.
        (rmc_with("A", ",A,V"), true),
        (rmc_with("A", ",E,S"), false),
        // One letter for each satellite system. GNS gives no position.
        (
            format!("GNGNS,123519,{PLACE},AA,08,0.9,545.4,46.9,,,V"),
            false,
        ),
        (
            format!("GNGNS,123519,{PLACE},EN,08,0.9,545.4,46.9,,,V"),
            false,
        ),
    ] {
        assert_eq!(fixes(&body), fix, "{body}");
    }
    assert_eq!(read_one(&rmc_with("A", ",X")), Err(Refusal::Field(12)));
    assert_eq!(read_one(&rmc_with("A", ",AE,V")), Err(Refusal::Field(12)));
}

#[test]
fn refused_sentences_are_named_and_counted() {
    let mut reader = Reader::default();
    let good = "GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,";
    let mut lines: Vec<(Vec<u8>, Option<Refusal>)> = vec![
        (b"$GPGGA,1235".to_vec(), None),
        (framed(good), Some(Refusal::CutShort)),
        (
            [b"$GP".to_vec(), vec![b'0'; 200]].concat(),
            Some(Refusal::TooLong),
        ),
        (b"$GPGGA,\xff".to_vec(), Some(Refusal::NotText(0xff))),
        (b"$GPGGA,123519\r\n".to_vec(), Some(Refusal::NoChecksum)),
        (b"$GPGGA,123519*7\r\n".to_vec(), Some(Refusal::NoChecksum)),
        (framed("GPGSV,3,1,11"), None),
    ];
    let mut wrong = framed(good);
    wrong[10] ^= 1;
    let computed = good.bytes().fold(0, |sum, byte| sum ^ byte);
    let (received, computed) = (computed, computed ^ 1);
    lines.push((wrong, Some(Refusal::Checksum { received, computed })));
    for (field, replaced) in [
        (
            1,
            "GPGGA,243519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
        (
            2,
            "GPGGA,123519,4860.000,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
        (
            2,
            "GPGGA,123519,9007.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
        (
            3,
            "GPGGA,123519,4807.038,E,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
        (
            4,
            "GPGGA,123519,4807.038,N,1131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
        (2, "GPGGA,123519,,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        (
            6,
            "GPGGA,123519,4807.038,N,01131.000,E,9,08,0.9,545.4,M,46.9,M,,",
        ),
        (
            9,
            "GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,5.4.5,M,46.9,M,,",
        ),
        (
            10,
            "GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,F,46.9,M,,",
        ),
        (6, "GPGGA,123519,4807.038,N,01131.000,E"),
        (
            0,
            "gPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
        ),
    ] {
        lines.push((framed(replaced), Some(Refusal::Field(field))));
    }
    for (line, refusal) in lines {
        let found = read(&mut reader, &line);
        let got = found.iter().find_map(|result| result.err());
        assert_eq!(got, refusal, "{}", String::from_utf8_lossy(&line));
    }
    assert_eq!(reader.counts().taken, 1);
    assert_eq!(reader.counts().others, 1);
    assert_eq!(reader.counts().refused, [1, 1, 1, 2, 1, 11]);
    assert_eq!(reader.counts().all_refused(), 17);
}

/// A leap second is second 60.
#[test]
fn times_of_the_day_are_those_of_a_clock() {
    let gga = |time: &str| {
        read_one(&format!(
            "GPGGA,{time},4807.038,N,01131.000,E,1,08,0.9,0,M,,,,"
        ))
    };
    for (time, milliseconds) in [
        ("000000", 0),
        ("235959.999", 86_399_999),
        ("235960.5", 86_400_500),
    ] {
        let Ok(Sentence::Gga(gga)) = gga(time) else {
            panic!("a good sentence")
        };
        assert_eq!(gga.time_ms, Some(milliseconds));
    }
    for time in ["240000", "126000", "123561", "1235", "-10000", "12:000"] {
        assert_eq!(gga(time), Err(Refusal::Field(1)), "{time}");
    }
}

#[test]
fn a_place_has_its_sign_in_its_hemisphere_alone() {
    let found = read_one("GPGGA,123519,-707.038,N,01131.000,E,1,08,0.9,0,M,,,,");
    assert_eq!(found, Err(Refusal::Field(2)));
}

#[test]
fn a_sentence_is_too_long_at_the_first_byte_without_room() {
    for last in [b',', b'A', b'*'] {
        let mut reader = Reader::default();
        assert_eq!(read(&mut reader, b"$"), []);
        assert_eq!(read(&mut reader, &[b'A'; 100]), []);
        assert_eq!(read(&mut reader, &[last]), [Err(Refusal::TooLong)]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_bytes_make_the_reader_panic_or_lose_the_next_good_sentence(
        bytes in vec(any::<u8>(), 0..400),
    ) {
        let mut reader = Reader::default();
        read(&mut reader, &bytes);
        let good = framed("GNRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W");
        prop_assert!(read(&mut reader, &good).iter().any(Result::is_ok));
    }

    #[test]
    fn only_measured_qualities_and_modes_give_a_fix(
        quality in "[0-9]?[0-9A-Z]?", status in "[AV]",
        mode in "[ADEFMNPRS]?[A-Z]?", follows in "(,[A-Z]?)?",
    ) {
        let one_of = |text: &str, letters: &str| text.len() == 1 && letters.contains(text);
        prop_assert_eq!(fixes(&gga_with(&quality)), one_of(&quality, "12345"));
        let measured = mode.is_empty() || one_of(&mode, "ADFPR");
        let body = rmc_with(&status, &format!(",{mode}{follows}"));
        prop_assert_eq!(fixes(&body), status == "A" && measured, "{}", body);
    }

    #[test]
    fn a_sentence_with_one_changed_byte_is_never_taken_for_another(
        place in 0..70_usize, byte in any::<u8>(),
    ) {
        let mut line = framed("GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,");
        let place = place % line.len();
        let found = |line: &[u8]| -> Vec<Sentence> {
            read(&mut Reader::default(), line).into_iter().filter_map(Result::ok).collect()
        };
        let good = found(&line);
        line[place] = byte;
        // The change may have no effect: ends of line are equivalent, and a checksum may have
        // lower-case letters.
        let changed = found(&line);
        prop_assert!(changed.is_empty() || changed == good, "{changed:?}");
    }

    #[test]
    fn fields_of_any_text_never_panic_and_stay_within_their_bounds(
        fields in vec("[0-9.,NSEWAVM-]{0,14}", 0..16), gga in any::<bool>(),
    ) {
        let kind = if gga { "GPGGA" } else { "GPRMC" };
        let line = framed(&format!("{kind},{}", fields.join(",")));
        for sentence in read(&mut Reader::default(), &line).into_iter().flatten() {
            let place = match sentence {
                Sentence::Gga(gga) => gga.place,
                Sentence::Rmc(rmc) => rmc.place,
            };
            if let Some(Place { latitude, longitude }) = place {
                prop_assert!(latitude.abs() <= 900_000_000 && longitude.abs() <= 1_800_000_000);
            }
        }
    }

    #[test]
    fn places_are_read_to_the_nearest_unit(
        latitude in 0..900_000_000_i64, longitude in 0..1_800_000_000_i64, decimals in 4..8_usize,
    ) {
        // Written with floating-point arithmetic, read with integers.
        let text = |units: i64, wide: usize| {
            let (whole, minutes) = (units / 10_000_000, (units % 10_000_000) as f64 * 6e-6);
            let minutes = minutes.min(59.9999);
            let width = decimals + 3;
            (format!("{whole:0wide$}{minutes:0width$.decimals$}"), whole, minutes)
        };
        let (north, ..) = text(latitude, 2);
        let (east, ..) = text(longitude, 3);
        prop_assume!(!north[2..].starts_with("60") && !east[3..].starts_with("60"));
        let Ok(Sentence::Gga(gga)) = read_one(&format!("GPGGA,000000,{north},N,{east},E,1,08,0.9,0,M,,,,"))
        else { panic!("a good sentence") };
        let place = gga.place.unwrap();
        let value = |text: &str, wide: usize| {
            let degrees: f64 = text[..wide].parse().unwrap();
            let minutes: f64 = text[wide..].parse().unwrap();
            (degrees + minutes / 60.0) * 1e7
        };
        for (got, exact) in [(place.latitude, value(&north, 2)), (place.longitude, value(&east, 3))] {
            prop_assert!((f64::from(got) - exact).abs() <= 0.51, "{got} {exact}");
        }
    }
}
