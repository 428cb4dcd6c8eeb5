//! Tests of examples/python/weigh.py. The scales are read off the paper's model, the chain of eight
//! joints in double precision. Without Python the tests are skipped and say so.

use crate::python;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use tautrack::robots::b2p2::model::belt::TautBelt;
use tautrack::robots::b2p2::parameters::{LENGTHS, Lengths, SEGMENTS, Tabulated};
use tautrack::robots::b2p2::{Parameters, Posture};
use tautrack::settings::{Setting, Settings};
use tautrack_host_tests::programs::setup::checkout;

/// Chassis angle and pitch in degrees, and the two axles on scales.
const POSTURES: [(f64, f64, [usize; 2]); 6] = [
    (60.0, 0.0, [1, 2]),
    (20.0, 0.0, [1, 2]),
    (90.0, 0.0, [1, 2]),
    (60.0, 15.0, [1, 2]),
    (60.0, -15.0, [1, 2]),
    (-55.0, 20.0, [1, 3]),
];
/// Standard deviations: of a reading, kg, and of the angles, degrees.
const SCALE_ERROR: f64 = 0.01;
const PITCH_ERROR: f64 = 0.1;
const JOINT_ERROR: f64 = 0.2;

/// What docs/weighing.md installs.
const NUMPY: &str = "numpy==2.4.6";

/// Python, and a folder for the files of one test.
struct Bench(PathBuf, PathBuf);

impl Bench {
    fn new(name: &str) -> Option<Self> {
        let python = python::python("python-weigh", &[NUMPY])?;
        let folder = std::env::temp_dir().join(format!("tautrack-weigh-{name}"));
        fs::create_dir_all(&folder).unwrap();
        fs::write(
            folder.join("dump.toml"),
            "[[node]]\nid = 2\nidentity = [0, 1, 1, 2]\n[node.settings]\n\
             [[node]]\nid = 1\nidentity = [0, 3, 1, 1]\n[node.settings]\n",
        )
        .unwrap();
        Some(Self(python, folder))
    }

    fn weigh(&self, readings: &str) -> Output {
        fs::write(self.1.join("weighing.toml"), readings).unwrap();
        let program = checkout::root().unwrap().join("examples/python/weigh.py");
        Command::new(&self.0)
            .arg(program)
            .args(["weighing.toml", "--dump", "dump.toml"])
            .current_dir(&self.1)
            .output()
            .unwrap()
    }

    fn dump(&self) -> String {
        fs::read_to_string(self.1.join("dump.toml")).unwrap()
    }

    /// The masses that the program has written for each node.
    fn settings(&self) -> [Settings; 2] {
        let dump: toml::Table = self.dump().parse().unwrap();
        let nodes = dump["node"].as_array().unwrap();
        [0, 1].map(|node| {
            let mut settings = Settings::default();
            for (name, value) in nodes[node]["settings"].as_table().unwrap() {
                let setting = Setting::from_name(name).unwrap();
                let value = value.as_integer().unwrap() as i32;
                settings.set(setting.description().key, value).unwrap();
            }
            settings
        })
    }

    /// What the program says when it refuses these readings, and leaves the dump as it was.
    fn refusal(&self, readings: &str) -> String {
        let before = self.dump();
        let output = self.weigh(readings);
        assert_eq!(output.status.code(), Some(1), "{readings}");
        assert_eq!(self.dump(), before);
        String::from_utf8(output.stderr).unwrap()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.1);
    }
}

/// Errors of readings, and what a robot of the test is made of.
struct Random(u64);

impl Random {
    /// Has no errors.
    fn none() -> Self {
        Self(0)
    }

    /// Uniform in -1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / f64::from(1_u32 << 31) / f64::from(1_u32 << 21) - 1.0
    }

    /// Uniform with a standard deviation of 1.
    fn deviate(&mut self) -> f64 {
        if self.0 == 0 {
            return 0.0;
        }
        3.0_f64.sqrt() * self.next()
    }
}

/// The first lines of the file.
fn head() -> String {
    format!(
        "scale_error_kg = {SCALE_ERROR}\npitch_error_degrees = {PITCH_ERROR}\n\
         joint_error_degrees = {JOINT_ERROR}\n"
    )
}

/// A robot of the model. Its inertias do not matter here, so they are those of large bodies.
fn robot(masses: [f64; 3], places: [[f64; 3]; 3]) -> Parameters<f64> {
    let segments: [Tabulated; 3] = core::array::from_fn(|body| Tabulated {
        mass: masses[body],
        centre_of_mass: places[body],
        inertia_about_origin: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]],
    });
    Parameters::new(&Lengths { ..LENGTHS }, &segments).unwrap()
}

fn joints(joint_degrees: f64, pitch_degrees: f64) -> [f64; 8] {
    let settings = Settings::default();
    let k = f64::from(settings.get(Setting::LengthK)) * 1e-6;
    let theta = joint_degrees.to_radians();
    let belt = TautBelt::<f64>::new(k, LENGTHS.l1, LENGTHS.l2).unwrap();
    let slid = belt.extension(theta).length - LENGTHS.axle_3;
    [
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        pitch_degrees.to_radians(),
        theta,
        slid,
    ]
}

/// The file with what scales show under this robot, with errors of `random`.
fn readings(robot: &Parameters<f64>, random: &mut Random) -> String {
    let half_gauge = f64::from(Settings::default().get(Setting::TrackGauge)) * 0.5e-6;
    let mut text = head();
    for (joint_degrees, pitch_degrees, [first, second]) in POSTURES {
        let joints = joints(
            joint_degrees + JOINT_ERROR * random.deviate(),
            pitch_degrees + PITCH_ERROR * random.deviate(),
        );
        let posture = Posture::new(robot, &joints);
        let (axles, cog) = posture.along_heading();
        let (near, far) = (axles[first - 1], axles[second - 1]);
        let front = robot.mass() * (cog - near) / (far - near);
        // R0's first axis points to the right.
        let left = -posture.cog()[0] / half_gauge;
        let _ = write!(
            text,
            "[[weighing]]\njoint_degrees = {joint_degrees}\npitch_degrees = {pitch_degrees}\n"
        );
        for (axle, force) in [(first, robot.mass() - front), (second, front)] {
            let mut error = || SCALE_ERROR * random.deviate();
            let sides = [1.0, -1.0].map(|side| 0.5 * force * (1.0 + side * left) + error());
            let _ = writeln!(text, "axle_{axle}_kg = {sides:?}");
        }
    }
    text
}

/// The robot of these settings.
fn found(settings: &Settings) -> Parameters<f64> {
    let value = |setting: Setting| f64::from(settings.get(setting)) * 1e-6;
    robot(
        [Setting::Body1Mass, Setting::Body2Mass, Setting::Body3Mass].map(value),
        [
            [
                value(Setting::Body1Forward),
                value(Setting::BodyHeight),
                -value(Setting::Body1Left),
            ],
            [
                value(Setting::Body2Up),
                -value(Setting::Body2Forward),
                -value(Setting::Body2Left),
            ],
            [
                value(Setting::Body3Up),
                -value(Setting::Body3Left),
                value(Setting::Body3Forward),
            ],
        ],
    )
}

#[test]
fn weighed_robots_have_their_centre_of_gravity_within_8_mm() {
    let Some(bench) = Bench::new("robots") else {
        return;
    };
    let mut random = Random(7);
    for _ in 0..10 {
        let masses = SEGMENTS.map(|segment| segment.mass * (1.0 + 0.2 * random.next()));
        let places = SEGMENTS.map(|segment| {
            segment
                .centre_of_mass
                .map(|place| place + 0.02 * random.next())
        });
        let truth = robot(masses, places);
        let output = bench.weigh(&readings(&truth, &mut random));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        for settings in bench.settings() {
            let found = found(&settings);
            assert!((found.mass() - truth.mass()).abs() < 0.03);
            for joint_degrees in [-60.0, -30.0, 0.0, 30.0, 60.0] {
                let joints = joints(joint_degrees, 0.0);
                let cog = |robot| Posture::new(robot, &joints).cog();
                let (expected, found) = (cog(&truth), cog(&found));
                let off = (0..3).map(|axis| (expected[axis] - found[axis]).powi(2));
                let off = off.sum::<f64>().sqrt();
                assert!(off < 8e-3, "{joint_degrees} degrees: {off} m");
            }
        }
    }
}

#[test]
fn readings_without_errors_of_the_robot_of_the_settings_change_none_of_them() {
    let Some(bench) = Bench::new("exact") else {
        return;
    };
    let default = Settings::default();
    let output = bench.weigh(&readings(&found(&default), &mut Random::none()));
    assert!(output.status.success(), "{output:?}");
    for settings in bench.settings() {
        assert_eq!(format!("{settings:?}"), format!("{default:?}"));
    }
}

#[test]
fn the_page_about_weighing_installs_what_its_program_needs() {
    let page = checkout::root().unwrap().join("docs/weighing.md");
    assert!(fs::read_to_string(page).unwrap().contains(NUMPY));
}

#[test]
fn a_reading_that_contradicts_the_others_is_named() {
    let Some(bench) = Bench::new("contradiction") else {
        return;
    };
    let good = readings(&Parameters::paper(), &mut Random(1));
    // 0.4 kg are missing in one of them.
    let line = good
        .lines()
        .filter(|line| line.starts_with("axle_2_kg"))
        .nth(3);
    let line = line.unwrap();
    let sides: toml::Table = line.parse().unwrap();
    let [left, right] = [0, 1].map(|side| sides["axle_2_kg"][side].as_float().unwrap() - 0.2);
    let bad = good.replace(line, &format!("axle_2_kg = [{left}, {right}]"));
    let refusal = bench.refusal(&bad);
    assert!(refusal.contains("weighing 4, "), "{refusal}");
    assert!(refusal.contains("allowed 4"), "{refusal}");
}

#[test]
fn bad_readings_are_refused_with_value_and_bound() {
    let Some(bench) = Bench::new("refusal") else {
        return;
    };
    let file = |weighing: &str| format!("{}[[weighing]]\n{weighing}", head());
    for (weighing, why) in [
        (
            "joint_degrees = 200\npitch_degrees = 0",
            "joint_degrees = 200: allowed -120 to 120",
        ),
        (
            "joint_degrees = 0\npitch_degrees = nan",
            "pitch_degrees = nan: allowed -60 to 60",
        ),
        (
            "joint_degrees = 0\npitch_degrees = 0\naxle_1_kg = 4",
            "1 axles have readings",
        ),
        (
            "joint_degrees = 0\npitch_degrees = 0\naxle_1_kg = 4\naxle_2_kg = -1",
            "a reading in kg = -1: allowed 0 to 500",
        ),
        (
            "joint_degrees = 0\npitch_degrees = 0\naxle_4_kg = 4",
            "axle_4_kg",
        ),
        (
            "joint_degrees = 98.5\npitch_degrees = -10\naxle_2_kg = 4\naxle_3_kg = 4",
            "apart along the ground",
        ),
    ] {
        let refusal = bench.refusal(&file(weighing));
        assert!(refusal.contains(why), "{refusal}");
    }
    let weighing = "joint_degrees = 0\npitch_degrees = 0\naxle_1_kg = 4\naxle_2_kg = 4";
    let bad = file(weighing).replace("scale_error_kg = 0.01", "scale_error_kg = 0");
    let refusal = bench.refusal(&bad);
    assert!(
        refusal.contains("scale_error_kg = 0: allowed 0.0001 to 10"),
        "{refusal}"
    );
}

/// With pitches of both signs, readings at the wrong sign fit a robot whose masses are below its
/// belts.
#[test]
fn angles_with_the_wrong_sign_and_too_few_postures_are_refused() {
    let Some(bench) = Bench::new("signs") else {
        return;
    };
    let good = readings(&Parameters::paper(), &mut Random(2));
    let negated = |key: &str| {
        let negate = |line: &str| match line.split_once(&format!("{key} = ")) {
            Some((_, value)) => format!("{key} = {}\n", -value.parse::<f64>().unwrap()),
            None => format!("{line}\n"),
        };
        good.lines().map(negate).collect::<String>()
    };
    let refusal = bench.refusal(&negated("pitch_degrees"));
    assert!(refusal.contains("check the signs"), "{refusal}");
    let refusal = bench.refusal(&negated("joint_degrees"));
    assert!(refusal.contains("would be below the line"), "{refusal}");
    let one: Vec<_> = good.split("[[weighing]]").take(2).collect();
    let refusal = bench.refusal(&one.join("[[weighing]]"));
    assert!(refusal.contains("weigh at more"), "{refusal}");
}
