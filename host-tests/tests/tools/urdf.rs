//! Tests of the robots' URDF files: they are XML, their joints form a tree, and in postures of the
//! simulated robots their links and centre of gravity are where the plants have them.

use crate::docs::root;
use core::f64::consts::TAU;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::fs;
use tautrack::link::Shaft;
use tautrack_host_tests::robots::b2p2::plant::{B2p2, B2p2Parameters};
use tautrack_host_tests::robots::crawler::plant::{Crawler, CrawlerParameters, Profile};
use tautrack_host_tests::robots::hylos::plant::{Hillside, Hylos, HylosParameters};
use tautrack_host_tests::robots::rt_mover::plant::{RtMover, RtMoverParameters};
use tautrack_host_tests::robots::{Kind, hylos};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::ground::Ground;

/// Element of an XML file; its text is left out.
#[derive(Debug, Default)]
struct Element {
    name: String,
    attributes: BTreeMap<String, String>,
    children: Vec<Element>,
}

impl Element {
    /// Reads a file; panics if its tags are not closed in order.
    fn read(text: &str) -> Self {
        let mut open = vec![Self::default()];
        for tag in text.split('<').skip(1) {
            let (tag, _) = tag.split_once('>').expect("the end of a tag");
            if tag.starts_with(['?', '!']) {
                continue;
            }
            if let Some(name) = tag.strip_prefix('/') {
                let closed = open.pop().expect("an open tag");
                assert_eq!(closed.name, name);
                open.last_mut().expect("its parent").children.push(closed);
                continue;
            }
            let (tag, is_empty) = match tag.strip_suffix('/') {
                Some(tag) => (tag, true),
                None => (tag, false),
            };
            let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
            let mut element = Self {
                name: name.to_owned(),
                ..Self::default()
            };
            while let Some((key, value)) = rest.split_once("=\"") {
                let (value, after) = value.split_once('"').expect("the end of a value");
                let key = key.trim().to_owned();
                let before = element.attributes.insert(key, value.to_owned());
                assert_eq!(before, None, "{tag}");
                rest = after;
            }
            assert_eq!(rest.trim(), "", "{tag}");
            if is_empty {
                open.last_mut().expect("its parent").children.push(element);
            } else {
                open.push(element);
            }
        }
        let [file] = <[Self; 1]>::try_from(open).expect("every tag is closed");
        let [root] = <[Self; 1]>::try_from(file.children).expect("one root");
        root
    }

    fn all(&self, name: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    fn child(&self, name: &str) -> Option<&Self> {
        let mut all = self.all(name);
        let first = all.next();
        assert!(all.next().is_none(), "two {name} in {self:?}");
        first
    }

    fn text(&self, attribute: &str) -> &str {
        let found = self.attributes.get(attribute);
        found.unwrap_or_else(|| panic!("{} has no {attribute}", self.name))
    }

    fn number(&self, attribute: &str) -> f64 {
        self.text(attribute).parse().expect("a number")
    }

    fn vector(&self, attribute: &str) -> Vector3<f64> {
        let numbers = self.text(attribute).split(' ').map(str::parse);
        let numbers: Result<Vec<f64>, _> = numbers.collect();
        Vector3::from_vec(numbers.expect("numbers"))
    }
}

/// Robot as its URDF file describes it.
struct Robot(Element);

impl Robot {
    fn read(name: &str) -> Self {
        let path = root().join(format!("examples/ros2/urdf/{name}.urdf"));
        let robot = Element::read(&fs::read_to_string(path).expect("the file"));
        assert_eq!((robot.name.as_str(), robot.text("name")), ("robot", name));
        Self(robot)
    }

    fn link(&self, name: &str) -> &Element {
        let mut links = self.0.all("link");
        let found = links.find(|link| link.text("name") == name);
        found.unwrap_or_else(|| panic!("no link {name}"))
    }

    /// Poses of all links if the base is at the origin and the joints are at these places; other
    /// joints are at zero.
    fn poses(&self, places: &BTreeMap<String, f64>) -> BTreeMap<String, Isometry3<f64>> {
        let mut poses = BTreeMap::from([("base_link".to_owned(), Isometry3::identity())]);
        for joint in self.0.all("joint") {
            let name = joint.text("name");
            let linked = |end: &str| joint.child(end).expect("a link").text("link").to_owned();
            let place = match joint.child("mimic") {
                None => places.get(name).copied().unwrap_or(0.0),
                Some(mimic) => {
                    let other = places.get(mimic.text("joint")).copied().unwrap_or(0.0);
                    mimic.number("multiplier") * other
                }
            };
            let motion = match joint.text("type") {
                "fixed" => Isometry3::identity(),
                "prismatic" => {
                    let axis = joint.child("axis").expect("an axis").vector("xyz");
                    Translation3::from(axis * place).into()
                }
                "revolute" | "continuous" => {
                    let axis = joint.child("axis").expect("an axis").vector("xyz");
                    Isometry3::rotation(axis * place)
                }
                other => panic!("{name} is {other}"),
            };
            let origin = joint.child("origin").expect("an origin");
            assert!(!origin.attributes.contains_key("rpy"), "{name} is turned");
            let origin = Isometry3::from(Translation3::from(origin.vector("xyz")));
            // Joints are in the order of the tree.
            let parent = poses[&linked("parent")];
            let before = poses.insert(linked("child"), parent * origin * motion);
            assert_eq!(before, None, "{name}: its child has two parents");
        }
        poses
    }

    /// Mass, kg, and centre of gravity, m, with its links at these poses.
    fn mass(&self, poses: &BTreeMap<String, Isometry3<f64>>) -> (f64, Vector3<f64>) {
        let (mut sum, mut moment) = (0.0, Vector3::zeros());
        for link in self.0.all("link") {
            let Some(inertial) = link.child("inertial") else {
                continue;
            };
            let mass = inertial.child("mass").expect("a mass").number("value");
            let centre = inertial.child("origin").expect("a centre").vector("xyz");
            let centre = poses[link.text("name")] * Point3::from(centre);
            sum += mass;
            moment += centre.coords * mass;
        }
        (sum, moment / sum)
    }

    /// Asserts that each body of the plant is where the link with its name is, relative to the
    /// first body, and that the centre of gravity is where the plant has it.
    fn assert_is_like(&self, plant: &dyn Plant, places: &BTreeMap<String, f64>, error: f64) {
        let links = self.poses(places);
        let bodies: Vec<_> = plant.bodies().iter().map(|body| body.name).collect();
        let poses = plant.poses().into_iter().map(|pose| {
            let [x, y, z, w] = pose.rotation;
            let rotation = UnitQuaternion::from_quaternion([x, y, z, w].into());
            Isometry3::from_parts(pose.place.into(), rotation)
        });
        let poses: Vec<_> = poses.collect();
        let base = poses[0] * links[bodies[0]].inverse();
        for (name, pose) in bodies.iter().zip(&poses) {
            let link = base * links[*name];
            let apart = (link.translation.vector - pose.translation.vector).norm();
            assert!(apart < error, "{name} is {apart} m apart");
            // The plants do not publish how far a wheel has turned.
            let axes = [Vector3::y(), Vector3::x()];
            let known = if name.ends_with("wheel") { 1 } else { 2 };
            for axis in &axes[..known] {
                let apart = (link * axis - pose * axis).norm();
                assert!(apart < 2.0 * error, "{name} is turned by {apart} rad");
            }
        }
        let (_, cog) = self.mass(&links);
        let apart = (base * Point3::from(cog)).coords - Vector3::from(plant.truth().cog);
        assert!(apart.norm() < error, "centre of gravity: {apart}");
    }
}

/// Error of the numbers in the files, with a margin for sums, m.
const ROUNDING: f64 = 1e-8;
/// Error by which the joints of the physics engine give under load, m.
const ENGINE: f64 = 2e-3;

/// Turns the shafts of the plant's motors by these angles (rad) within half a second, and waits as
/// long.
fn turn(plant: &mut dyn Plant, angles: &[f64]) {
    for step in 1..=1_000 {
        let (done, rate) = if step <= 500 {
            (f64::from(step) / 500.0, 2.0)
        } else {
            (1.0, 0.0)
        };
        let shafts = angles.iter().map(|angle| {
            Some(Shaft {
                position: (angle * done / TAU * 4_294_967_296.0) as i64,
                velocity: (angle * rate) as f32,
            })
        });
        plant.step(&shafts.collect::<Vec<_>>());
    }
}

fn named<const N: usize>(places: [(&str, f64); N]) -> BTreeMap<String, f64> {
    places.map(|(name, place)| (name.to_owned(), place)).into()
}

#[test]
fn the_links_of_b2p2_are_where_the_plant_has_its_bodies() {
    let robot = Robot::read("b2p2");
    let parameters = B2p2Parameters {
        initial_theta: 0.5,
        ..B2p2Parameters::nominal()
    };
    let mut plant = B2p2::new(&parameters, &Ground::Flat, 1);
    let places = |plant: &B2p2| {
        let truth = plant.truth();
        named([("chassis_joint", truth.theta), ("screw", truth.extension)])
    };
    robot.assert_is_like(&plant, &places(&plant), ROUNDING);
    turn(&mut plant, &[0.0, 0.0, 0.4, TAU]);
    let after = places(&plant);
    assert!(after["chassis_joint"] > 0.8, "{after:?}");
    robot.assert_is_like(&plant, &after, ENGINE);
}

#[test]
fn the_link_of_the_crawler_is_where_the_plant_has_its_body() {
    let plant = Crawler::new(&CrawlerParameters::nominal(), &Profile::default(), 1);
    Robot::read("crawler").assert_is_like(&plant, &BTreeMap::new(), ROUNDING);
}

#[test]
fn the_links_of_hylos_are_where_the_plant_has_its_bodies() {
    let robot = Robot::read("hylos");
    let hillside = Hillside {
        slope: 0.0,
        foot_y: 0.0,
        wave_height: 0.0,
        wave_length: [1.0; 2],
        extent: [[-2.0, 2.0]; 2],
    };
    let mut plant = Hylos::new(&HylosParameters::nominal([0.0; 3]), &hillside, 1);
    let places = |plant: &Hylos| {
        let (detail, mut places) = (plant.detail(), BTreeMap::new());
        // The nodes of a leg are hip, knee, steering and wheel.
        let (legs, _) = hylos::FACTS.nodes.as_chunks::<4>();
        for (leg, [hip, knee, steering, _]) in legs.iter().enumerate() {
            let angles = [
                detail.legs[leg][0],
                detail.legs[leg][1],
                detail.steering[leg],
            ];
            for ((name, _), angle) in [hip, knee, steering].into_iter().zip(angles) {
                places.insert(name.as_str().to_owned(), angle);
            }
        }
        places
    };
    robot.assert_is_like(&plant, &places(&plant), ROUNDING);
    turn(
        &mut plant,
        &[
            [0.2, -0.3, 0.4, 0.0],
            [0.1, -0.2, -0.3, 0.0],
            [0.1, -0.1, 0.2, 0.0],
            [0.2, -0.2, -0.4, 0.0],
        ]
        .concat(),
    );
    let after = places(&plant);
    assert!(after["rear_right_steering"] < -0.2, "{after:?}");
    robot.assert_is_like(&plant, &after, ENGINE);
}

#[test]
fn the_links_of_rt_mover_are_where_the_plant_has_its_bodies() {
    let robot = Robot::read("rt-mover");
    let mut plant = RtMover::new(&RtMoverParameters::nominal(), &Ground::Flat, 1);
    let places = |plant: &RtMover| {
        let nodes = Kind::RtMover.facts().nodes.iter();
        let names = nodes.map(|(name, _)| name.as_str().to_owned());
        names.zip(plant.joints()).collect::<BTreeMap<_, _>>()
    };
    robot.assert_is_like(&plant, &places(&plant), ROUNDING);
    // Wheels, front and rear steering, front and rear roll, seat.
    turn(&mut plant, &[0.5, 0.5, 0.5, 0.5, 0.3, -0.2, 0.15, 0.1, 0.2]);
    let after = places(&plant);
    assert!(after["seat_pitch"] > 0.15, "{after:?}");
    assert!(after["front_roll"] > 0.1, "{after:?}");
    robot.assert_is_like(&plant, &after, ENGINE);
}

/// Masses from the papers, and the crawler's assumed one (docs/plant.md).
#[test]
fn the_links_weigh_what_the_robot_weighs() {
    for (name, mass) in [
        ("b2p2", 8.315_283),
        ("crawler", 5.0),
        ("hylos", 25.0),
        ("rt-mover", 28.0),
    ] {
        let robot = Robot::read(name);
        let (sum, _) = robot.mass(&robot.poses(&BTreeMap::new()));
        assert!((sum - mass).abs() < ROUNDING, "{name}: {sum} kg");
    }
}

/// The paper tabulates body 1 in axes forward, up, right, about the origin. The parallel axes of
/// its centre of mass are calculated by hand.
#[test]
fn the_products_of_inertia_have_the_signs_of_the_paper() {
    let robot = Robot::read("b2p2");
    let inertial = robot.link("body_1").child("inertial").expect("a mass");
    let inertia = inertial.child("inertia").expect("an inertia");
    let forward_up = -0.033_872 + 6.356_067 * 0.160_894 * 0.034_997;
    let forward_right = 0.002_259 - 6.356_067 * 0.160_894 * 0.002_784;
    assert!((inertia.number("ixz") - forward_up).abs() < ROUNDING);
    assert!((inertia.number("ixy") + forward_right).abs() < ROUNDING);
}

/// Reading the poses fails if a child has two parents or none.
#[test]
fn the_joints_connect_all_links_and_a_drive_has_its_limits() {
    for (name, kind) in [
        ("b2p2", Kind::B2p2),
        ("crawler", Kind::Crawler),
        ("hylos", Kind::Hylos),
        ("rt-mover", Kind::RtMover),
    ] {
        let robot = Robot::read(name);
        let poses = robot.poses(&BTreeMap::new());
        let links: Vec<_> = robot.0.all("link").map(|link| link.text("name")).collect();
        let mut sorted = links.clone();
        sorted.sort_unstable();
        let reached: Vec<_> = poses.keys().map(String::as_str).collect();
        assert_eq!(sorted, reached, "{name}");

        let joints = || robot.0.all("joint").map(|joint| joint.text("name"));
        let nodes = kind.facts().nodes.iter().map(|(node, _)| node.as_str());
        for node in nodes.filter(|node| *node != "guard" && !node.ends_with("track")) {
            assert_eq!(joints().filter(|joint| *joint == node).count(), 1, "{node}");
        }
        for joint in robot.0.all("joint") {
            let driven = !matches!(joint.text("name"), "base") && joint.child("mimic").is_none();
            assert_eq!(joint.child("limit").is_some(), driven, "{joint:?}");
            let Some(limit) = joint.child("limit") else {
                continue;
            };
            let positive = limit.number("effort") > 0.0 && limit.number("velocity") > 0.0;
            let travel = !matches!(joint.text("type"), "revolute" | "prismatic")
                || limit.number("lower") < limit.number("upper");
            assert!(positive && travel, "{joint:?}");
        }
    }
}
