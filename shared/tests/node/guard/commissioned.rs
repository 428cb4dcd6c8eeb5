//! Tests the values that the commissioning finds, and why it refuses them, with a board without
//! noise.

use super::commissioning::{Bench, Board, applied};
use tautrack::node::guard::commissioning::{Commissioning, Reason, progress, request};
use tautrack::sensors::{BodySensors, Fresh};

/// A board without noise that measures 100 times per second. Its constant errors are large.
fn quiet() -> Board {
    Board {
        noisy: 0.0,
        period: 0.01,
        readings_per_field: 10,
        rate_at_rest: [5.0, -5.0, 2.5].map(f64::to_radians),
        inclinometer_offset: [0.06, -0.05],
        // Its determinant is 1, so that it leaves the strength of the field as it is.
        soft_iron: [[1.1, 0.05, 0.0], [0.05, 1.0025 / 1.1, 0.0], [0.0, 0.0, 1.0]],
        ..Board::new()
    }
}

/// Commissions a board. Returns why it was refused, and the value.
fn refused(board: Board) -> Option<(u8, i32)> {
    let mut bench = Bench::new(board);
    bench
        .commission()
        .map(|reason| (reason, bench.commissioning.report().refused))
}

fn near<const N: usize>(got: [i32; N], exact: [f64; N], bound: f64) -> bool {
    got.into_iter()
        .zip(exact)
        .all(|(got, exact)| (f64::from(got) - exact).abs() <= bound)
}

#[test]
fn the_values_are_the_errors_of_the_board() {
    let board = quiet();
    let m = board.mounting;
    let mut bench = Bench::new(quiet());
    assert_eq!(bench.commission(), None);
    let report = bench.commissioning.report();
    assert_eq!((report.progress, report.axes), (progress::DONE, 7));
    let values = &report.values;
    // The mounting turns about x, then y, then z.
    let angles = [
        m[2][1].atan2(m[2][2]),
        -m[2][0].asin(),
        m[1][0].atan2(m[0][0]),
    ];
    let millidegrees = |angle: f64| angle.to_degrees() * 1e3;
    assert!(
        near(values.mounting, angles.map(millidegrees), 20.0),
        "{values:?}"
    );
    let rate = applied(&m, board.rate_at_rest);
    assert!(
        near(values.rate_at_rest, rate.map(millidegrees), 20.0),
        "{values:?}"
    );
    // On level ground the board shows the direction up of its mounting, and its offset.
    let up = m[2];
    let [pitch, roll] = [
        up[0].atan2(up[2]) + board.inclinometer_offset[0],
        up[1].atan2(up[0].hypot(up[2])) + board.inclinometer_offset[1],
    ];
    let shown = [
        pitch.sin() * roll.cos(),
        roll.sin(),
        pitch.cos() * roll.cos(),
    ];
    let [x, y, z] = applied(&m, shown);
    let level = [x.atan2(z), y.atan2(x.hypot(z))];
    assert!(
        near(values.level, level.map(millidegrees), 20.0),
        "{values:?}"
    );
    assert!(
        near(
            values.hard_iron,
            board.hard_iron.map(|field| field * 1e3),
            100.0
        ),
        "{values:?}"
    );
    // The inverse of the soft iron.
    let [[xx, xy, _], [_, yy, _], _] = board.soft_iron;
    let correction = [yy, xx, -xy].map(|factor| factor * 1e4);
    assert!(near(values.soft_iron, correction, 20.0), "{values:?}");
}

/// A fifth of the angle and 30 mrad.
#[test]
fn a_gyroscope_may_be_wrong_by_a_quarter_but_not_by_forty_percent() {
    for (factor, expected) in [(1.25, None), (0.75, None), (1.4, Some(())), (0.6, Some(()))] {
        let mut bench = Bench::new(Board {
            gyroscope: [factor; 3],
            ..quiet()
        });
        assert_eq!(bench.rest(request::LEVEL), None);
        bench.turn([0.0, 0.0, 15.0_f64.to_radians()], 3.0);
        let reason = bench.rest(request::NOSE_UP);
        assert_eq!(
            reason,
            expected.map(|()| Reason::GyroscopeSign as u8),
            "{factor}"
        );
        // 40 % of 15 degrees are 104.7 mrad.
        let value = bench.commissioning.report().refused;
        assert!(expected.is_none() || (100..110).contains(&value), "{value}");
    }
}

#[test]
fn an_inclinometer_with_a_wrong_sign_is_found() {
    for axis in 0..2 {
        let mut board = quiet();
        board.inclinometer[axis] = -1.0;
        let found = refused(board).map(|(reason, _)| reason);
        assert_eq!(found, Some(Reason::Inclinometer as u8), "{axis}");
    }
}

#[test]
fn a_turn_needs_enough_readings_of_an_ellipse_like_the_earth_s_field() {
    let (few, reason) = (Reason::TooFewFields as u8, Reason::NoEllipse as u8);
    // 6.6 of 7 rad in 30 s take 28.3 s.
    let fields = |readings_per_field| {
        refused(Board {
            readings_per_field,
            ..quiet()
        })
    };
    assert_eq!(fields(100), None);
    let (found, count) = fields(150).expect("a refusal");
    assert!(
        found == few && (18..=19).contains(&count),
        "{found} {count}"
    );
    let earth = |level: f64| {
        refused(Board {
            earth: [level, 0.0, -41.9],
            ..quiet()
        })
    };
    assert_eq!([earth(58.0), earth(6.0)], [None, None]);
    for level in [62.0, 4.0] {
        let (found, radius) = earth(level).expect("a refusal");
        assert_eq!(found, reason);
        let exact = level * 1e3;
        assert!(
            (f64::from(radius) - exact).abs() < 200.0,
            "{radius} {exact}"
        );
    }
    // A correction by the square root of the ratio of the axes: 1.9, then 2.1.
    for (ratio, expected) in [(1.9 * 1.9, None), (2.1 * 2.1, Some(reason))] {
        let soft = refused(Board {
            soft_iron: [[1.0, 0.0, 0.0], [0.0, 1.0 / ratio, 0.0], [0.0, 0.0, 1.0]],
            ..quiet()
        });
        assert_eq!(soft.map(|(reason, _)| reason), expected, "{ratio}");
    }
}

#[test]
fn a_turn_may_be_clockwise_and_ends_after_three_minutes() {
    let mut bench = Bench::new(quiet());
    assert_eq!(bench.commission(), None);
    bench.commissioning.request(request::TURN, false);
    bench.turn([0.0; 3], 30.0);
    assert_eq!(bench.ended(), None);
    bench.commissioning.request(request::TURN, false);
    bench.turn([1.0, 0.0, 0.0], 179.0);
    assert_eq!(bench.commissioning.report().progress, request::TURN);
    bench.turn([1.0, 0.0, 0.0], 2.0);
    assert_eq!(bench.ended(), Some(Reason::Timeout as u8));
    let angle = bench.commissioning.report().refused;
    assert!((990..1_010).contains(&angle), "{angle}");
}

/// The periods of half a second add up without rounding.
#[test]
fn a_turn_may_last_for_180_seconds_and_no_longer() {
    let mut commissioning = rested([[0.0; 3]; 2], Fresh::ALL);
    commissioning.request(request::TURN, false);
    let half_seconds = (1..1_000).find(|_| {
        commissioning.sense(&BodySensors::default(), 0.5);
        commissioning.report().progress != request::TURN
    });
    assert_eq!(half_seconds, Some(361));
}

#[test]
fn a_request_for_no_step_ends_the_step_under_way() {
    let mut bench = Bench::new(quiet());
    for step in [request::LEVEL, request::TURN] {
        assert_eq!(bench.rest(request::LEVEL), None);
        bench.commissioning.request(step, true);
        bench.turn([0.0; 3], 1.0);
        bench.commissioning.request(request::NONE, true);
        bench.turn([0.0; 3], 5.0);
        let report = bench.commissioning.report();
        assert_eq!((report.progress, report.reason), (request::NONE, 0));
    }
}

/// The robot turns at 1 rad/s, and each reading has a field. A turn ends after 6.6 rad.
#[test]
fn a_turn_with_24_fields_is_enough_and_one_with_23_is_not() {
    for (fields, period) in [(24, 0.277_5), (23, 0.29)] {
        let mut commissioning = rested([[0.0; 3]; 2], Fresh::ALL);
        commissioning.request(request::TURN, false);
        let mut readings = 0;
        while commissioning.report().progress == request::TURN {
            readings += 1;
            let angle = readings as f32 * period;
            let sensors = BodySensors {
                specific_force: [0.0, 0.0, 9.806_65],
                angular_rate: [0.0, 0.0, 1.0],
                magnetic_field: [22.0 * angle.cos(), -22.0 * angle.sin(), -40.0],
                fresh: Fresh::ALL,
                ..BodySensors::default()
            };
            commissioning.sense(&sensors, period);
        }
        assert_eq!(readings, fields);
        let report = commissioning.report();
        let expected = if fields == 24 {
            (progress::DONE, 0)
        } else {
            (progress::REFUSED, Reason::TooFewFields as u8)
        };
        assert_eq!((report.progress, report.reason), expected);
    }
}

/// Readings of a level board that rests for four seconds, with these rates in turn.
fn rested(rates: [[f32; 3]; 2], fresh: Fresh) -> Commissioning {
    let mut commissioning = Commissioning::default();
    commissioning.request(request::LEVEL, true);
    for step in 0..410 {
        let sensors = BodySensors {
            specific_force: [0.0, 0.0, 9.806_65],
            angular_rate: rates[step % 2],
            fresh,
            ..BodySensors::default()
        };
        commissioning.sense(&sensors, 0.01);
    }
    commissioning
}

/// Values of the settings are rounded to the nearest, away from zero and toward it.
#[test]
fn values_are_means_that_are_rounded_to_the_nearest_unit() {
    let milli = |value: f64| (value * 1e-3).to_radians() as f32;
    for (rate, expected) in [
        ([12.7, -12.7, 12.3], [13, -13, 12]),
        ([-12.3, 0.4, -0.4], [-12, 0, 0]),
        ([0.6, -0.6, 0.0], [1, -1, 0]),
    ] {
        for noise in [0.0, 20.0] {
            let around = |sign: f64| rate.map(|rate| milli(rate + sign * noise));
            let commissioning = rested([around(1.0), around(-1.0)], Fresh::ALL);
            let found = commissioning.report().values.rate_at_rest;
            assert_eq!(found, expected, "{noise}");
        }
    }
}

#[test]
fn a_rest_without_readings_or_with_a_fast_gyroscope_is_refused() {
    let refused = |rates, fresh| {
        let report = *rested([rates; 2], fresh).report();
        assert_eq!(report.progress, progress::REFUSED);
        (report.reason, report.refused)
    };
    let without = Fresh {
        inclinometer: false,
        ..Fresh::ALL
    };
    assert_eq!(refused([0.0; 3], without), (Reason::Moved as u8, 0));
    // 0.42 rad/s in all; the limit is 0.35 rad/s.
    let (reason, value) = refused([0.3, -0.3, 0.0], Fresh::ALL);
    assert!(
        reason == Reason::RateAtRest as u8 && value == 424,
        "{reason} {value}"
    );
}

#[test]
fn an_accelerometer_may_be_wrong_by_four_percent_but_not_by_six() {
    for (factor, accepted) in [(1.04, true), (0.96, true), (1.06, false), (0.94, false)] {
        let mut commissioning = Commissioning::default();
        commissioning.request(request::LEVEL, true);
        let sensors = BodySensors {
            specific_force: [0.0, 0.0, 9.806_65 * factor],
            fresh: Fresh::ALL,
            ..BodySensors::default()
        };
        for _ in 0..410 {
            commissioning.sense(&sensors, 0.01);
        }
        let report = commissioning.report();
        let reason = if accepted {
            0
        } else {
            Reason::NotGravity as u8
        };
        assert_eq!(report.reason, reason, "{factor}");
    }
}

/// The value is the angle by which the field turned: 6.6 rad, less the first step.
#[test]
fn a_field_that_turns_with_the_robot_is_refused_with_its_angle() {
    for axis in 0..2 {
        let mut board = quiet();
        board.magnetometer[axis] = -1.0;
        let (reason, angle) = refused(board).expect("a refusal");
        assert_eq!(reason, Reason::MagnetometerSign as u8);
        assert!((6_200..6_700).contains(&angle), "{axis}: {angle}");
    }
}

#[test]
fn a_magnetometer_without_numbers_has_no_field() {
    let refusal = refused(Board {
        magnetometer: [f64::NAN, 1.0, 1.0],
        mounting: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ..quiet()
    });
    assert_eq!(refusal, Some((Reason::TooFewFields as u8, 0)));
}
