//! Tests of the state q against independent computations: NMEA sentences, compass, plane and dead
//! reckoning.

use proptest::collection::vec;
use proptest::prelude::*;
use std::f64::consts::PI;
use tautrack::estimate::compass::{Compass, CompassError, HORIZONTAL_SHARE};
use tautrack::estimate::nmea::{Gga, Place, Reader, Refusal, Rmc, Sentence};
use tautrack::estimate::position::{
    FIRST_FIXES, Fix, GATE, JUMP_FIXES, LEAST_GAIN, Plane, Position, Verdict,
};
use tautrack::estimate::state::{Estimator, Joint, Validity};
use tautrack::sensors::BodySensors;
use tautrack::settings::Settings;
use tautrack::stability::attitude::Attitude;
use tautrack::units::Angle;
use tautrack_host_tests::world::gnss::{ReceiverParameters, geodetic};

/// Adds the checksum and the end of the line.
fn framed(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

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
    let (told, computed) = (computed, computed ^ 1);
    lines.push((wrong, Some(Refusal::Checksum { told, computed })));
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

/// Converts a field (north, west, up; uT) to the axes of a body with this heading, roll and pitch
/// (rad), in double precision.
fn in_body([north, west, up]: [f64; 3], [heading, roll, pitch]: [f64; 3]) -> [f32; 3] {
    // World axes to heading axes (about z), then roll about x (left side up), then pitch about y
    // (nose up).
    let (x, y) = (
        north * heading.cos() + west * heading.sin(),
        -north * heading.sin() + west * heading.cos(),
    );
    let (y, z) = (
        y * roll.cos() + up * roll.sin(),
        -y * roll.sin() + up * roll.cos(),
    );
    let (x, z) = (
        x * pitch.cos() + z * pitch.sin(),
        -x * pitch.sin() + z * pitch.cos(),
    );
    [x, y, z].map(|component| component as f32)
}

fn tilted(roll: f64, pitch: f64) -> Attitude {
    let mut attitude = Attitude::default();
    let sensors = BodySensors {
        inclination: [pitch as f32, roll as f32],
        ..BodySensors::default()
    };
    assert!(attitude.update(&sensors, 1e-3));
    attitude
}

#[test]
fn the_compass_keeps_its_error_over_directions_tilts_strengths_and_inclinations() {
    let (iron, declination) = ([11.0_f64, -7.0, 20.0], 3.7_f64.to_radians());
    let compass = Compass::new(
        iron.map(|component| component as f32),
        Angle::from_radians(declination as f32),
    );
    let mut worst = 0.0_f64;
    for (roll, pitch) in [
        (0.0, 0.0),
        (0.3, 0.0),
        (0.0, 0.75),
        (-0.4, 0.5),
        (0.2, -1.2),
    ] {
        let axes = tilted(roll, pitch).level_axes();
        for (strength, inclination) in [(20.0, 0.0), (47.5, 62.0), (65.0, -70.0), (50.0, 79.0)] {
            let inclination = f64::to_radians(inclination);
            let level = strength * inclination.cos();
            let field = [
                level * declination.cos(),
                -level * declination.sin(),
                -strength * inclination.sin(),
            ];
            for step in 0..36_000 {
                let heading = f64::from(step) / 18_000.0 * PI - PI;
                let mut reading = in_body(field, [heading, roll, pitch]);
                for (component, iron) in reading.iter_mut().zip(iron) {
                    *component += iron as f32;
                }
                let got = compass.heading(reading, &axes).expect("an earth's field");
                let exact = Angle::from_radians(heading as f32);
                worst = worst.max(f64::from((got - exact).degrees()).abs());
            }
        }
    }
    println!("worst error of the compass: {worst:.4} degrees");
    assert!(worst <= 0.163, "{worst} degrees");
}

#[test]
fn readings_that_are_no_earth_s_field_give_no_heading() {
    let (compass, level) = (Compass::default(), tilted(0.0, 0.0).level_axes());
    let heading = |field| compass.heading(field, &level);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut field = [20.0, 0.0, -40.0];
            field[axis] = bad;
            assert_eq!(heading(field), Err(CompassError::NotFinite));
        }
    }
    assert_eq!(heading([0.0; 3]), Err(CompassError::Strength(0.0)));
    assert_eq!(heading([-0.0; 3]), Err(CompassError::Strength(0.0)));
    assert!(matches!(heading([3e38; 3]), Err(CompassError::Strength(_))));
    assert!(matches!(
        heading([100.0, 0.0, 0.0]),
        Err(CompassError::Strength(_))
    ));
    assert!(matches!(
        heading([5.0, 0.0, -5.0]),
        Err(CompassError::Strength(_))
    ));
    let Err(CompassError::Steep(share)) = heading([5.0, 0.0, -45.0]) else {
        panic!("a field of 84 degrees")
    };
    assert!(share < HORIZONTAL_SHARE);
}

proptest! {
    #[test]
    fn no_field_makes_the_compass_panic(bits in any::<[u32; 3]>(), tilt in any::<[i16; 2]>()) {
        let [roll, pitch] = tilt.map(|tilt| f64::from(tilt) * 1e-4);
        let _ = Compass::default().heading(bits.map(f32::from_bits), &tilted(roll, pitch).level_axes());
    }
}

#[test]
fn the_plane_keeps_its_error_against_the_ellipsoid() {
    for (latitude, longitude) in [
        (47.48, -0.56),
        (-33.9, 151.2),
        (0.0, 179.9999),
        (65.0, 25.0),
        (-65.0, -180.0),
    ] {
        let site = ReceiverParameters {
            site: [latitude, longitude, 0.0],
            geoid: 0.0,
            ..ReceiverParameters::NOMINAL
        };
        let place = |metres: [f64; 3]| {
            let [latitude, longitude, _] = geodetic(&site, metres);
            Place {
                latitude: (latitude * 1e7).round() as i32,
                longitude: (longitude * 1e7).round() as i32,
            }
        };
        let plane = Plane::new(place([0.0; 3]));
        for (reach, bound) in [(100.0, 0.015), (1_000.0, 0.38)] {
            for step in 0..64 {
                let turn = f64::from(step) / 32.0 * PI;
                let scale = reach / turn.cos().abs().max(turn.sin().abs());
                let (north, west) = (scale * turn.cos(), scale * turn.sin());
                let [got_north, got_east] = plane.metres(place([north, west, 0.0])).map(f64::from);
                let error = (got_north - north).hypot(got_east + west);
                assert!(error <= bound, "{latitude}, {reach} m, {turn}: {error} m");
            }
        }
    }
}

/// Returns a fix at this distance (north, east, up; m) from a site, and its time, us. There are
/// five fixes per second.
fn fix(number: u32, [north, east, up]: [f64; 3]) -> (Fix, u64) {
    let site = ReceiverParameters {
        geoid: 0.0,
        ..ReceiverParameters::NOMINAL
    };
    let [latitude, longitude, height] = geodetic(&site, [north, -east, up]);
    let fix = Fix {
        time_ms: number * 200,
        place: Place {
            latitude: (latitude * 1e7).round() as i32,
            longitude: (longitude * 1e7).round() as i32,
        },
        altitude_mm: Some((height * 1e3).round() as i32),
    };
    (fix, u64::from(number) * 200_000)
}

#[test]
fn a_position_begins_with_three_fixes_that_agree() {
    let mut position = Position::new(0.45);
    for (number, north) in [(1, 0.0), (2, 5_000.0), (3, 0.0), (4, 1.0)] {
        let (fix, now) = fix(number, [north, 0.0, 0.0]);
        assert_eq!(position.fix(&fix, now), Verdict::Doubted);
        assert_eq!((position.fixed_us(), position.origin()), ([None; 2], None));
    }
    assert_eq!(FIRST_FIXES, 3);
    let (fix, now) = fix(5, [2.0, -1.0, 0.5]);
    assert_eq!(position.fix(&fix, now), Verdict::Believed);
    assert_eq!(position.fix(&fix, now), Verdict::Known);
    let metres = position.metres();
    for (got, expected) in metres.iter().zip([2.0, -1.0, 0.5]) {
        assert!((got - expected).abs() < 0.02, "{metres:?}");
    }
}

#[test]
fn a_jump_is_believed_only_after_ten_fixes_that_agree_with_each_other() {
    let mut position = Position::new(0.45);
    let mut take = |number: u32, north: f64| {
        let (fix, now) = fix(number, [north, 0.0, 0.0]);
        (position.fix(&fix, now), position.metres()[0])
    };
    for number in 1..=20 {
        take(number, 0.0);
    }
    // Fixes that alternate between two places never agree.
    for number in 21..=60 {
        let (verdict, north) = take(number, if number % 2 == 0 { 60.0 } else { -60.0 });
        assert!(verdict == Verdict::Doubted && north.abs() < 0.01, "{north}");
    }
    for number in 61..61 + JUMP_FIXES - 1 {
        let (verdict, north) = take(number, 200.0);
        assert!(verdict == Verdict::Doubted && north.abs() < 0.01, "{north}");
    }
    let (verdict, north) = take(61 + JUMP_FIXES, 200.0);
    assert!(
        verdict == Verdict::Believed && (north - 200.0).abs() < 0.05,
        "{north}"
    );
    // Within the gate, a fix moves the estimate by no more than its gain.
    let (_, north) = take(62 + JUMP_FIXES, 200.0 + f64::from(GATE) - 1.0);
    assert!(
        (north - 204.5).abs() < 0.05,
        "the second one's gain is a half: {north}"
    );
}

#[test]
fn settled_the_gain_is_one_part_in_a_hundred() {
    let mut position = Position::new(0.45);
    for number in 1..=LEAST_GAIN + 50 {
        let (fix, now) = fix(number, [0.0; 3]);
        position.fix(&fix, now);
    }
    let before = position.metres()[1];
    let (fix, now) = fix(LEAST_GAIN + 51, [0.0, 5.0, 0.0]);
    position.fix(&fix, now);
    let step = position.metres()[1] - before;
    assert!((step - 0.05).abs() < 2e-4, "{step}");
}

#[test]
fn small_steps_add_up_far_from_the_origin() {
    let mut position = Position::new(0.45);
    for number in 1..=3 {
        let (fix, now) = fix(number, [0.0; 3]);
        position.fix(&fix, now);
    }
    let axes = tilted(0.1, 0.6).level_axes();
    let heading = Angle::from_degrees(150.0);
    // 3 km in steps of 0.52 mm, nose up by 0.6 rad.
    let steps = 5_769_231_u32;
    for _ in 0..steps {
        position.advance(520, heading, &axes);
    }
    let way = f64::from(steps) * 520e-6;
    let (forward, left, up) = (
        way * 0.6_f64.cos(),
        -way * 0.6_f64.sin() * 0.1_f64.sin(),
        way * 0.6_f64.sin() * 0.1_f64.cos(),
    );
    let (sine, cosine) = 150.0_f64.to_radians().sin_cos();
    let expected = [
        forward * cosine - left * sine,
        -(forward * sine + left * cosine),
        up,
    ];
    for (got, expected) in position.metres().iter().zip(expected) {
        assert!(
            (f64::from(*got) - expected).abs() < 0.02,
            "{got} {expected}"
        );
    }
}

proptest! {
    #[test]
    fn garbage_never_makes_a_position_valid(chunks in vec(vec(any::<u8>(), 0..40), 1..200)) {
        let mut estimator = Estimator::new(&Settings::default());
        for (step, bytes) in (0..).zip(&chunks) {
            estimator.listen(bytes, step * 1_000);
        }
        let end_us = chunks.len() as u64 * 1_000;
        let attitude = Attitude::default();
        estimator.advance(0, None, [Joint::default(); 2], &attitude, end_us);
        let state = estimator.state(&attitude, end_us);
        prop_assert!(state.iter().all(|reading| reading.validity == Validity::Invalid && reading.value == 0.0));
    }

    #[test]
    fn sentences_with_swapped_and_struck_bytes_never_move_a_believed_position_far(
        hits in vec((0..2_000_usize, any::<u8>()), 1..200),
    ) {
        let mut estimator = Estimator::new(&Settings::default());
        let line = |step: u64| framed(&format!("GPGGA,{:06}.{:02},4728.70400,N,00033.79200,W,1,08,1.1,40.0,M,48.0,M,,", 120_000 + step / 5, step % 5 * 20));
        for step in 0..20 {
            estimator.listen(&line(step), step * 200_000);
        }
        let mut bytes: Vec<u8> = (20..50).flat_map(line).collect();
        for (place, byte) in hits {
            let place = place % bytes.len();
            bytes[place] = byte;
        }
        estimator.listen(&bytes, 10_000_000);
        let attitude = Attitude::default();
        estimator.advance(0, None, [Joint::default(); 2], &attitude, 10_000_000);
        let state = estimator.state(&attitude, 10_000_000);
        prop_assert!(state[..3].iter().all(|reading| reading.value.abs() <= GATE), "{state:?}");
    }
}
