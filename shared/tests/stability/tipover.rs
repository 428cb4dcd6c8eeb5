//! Tests the tip-over angles against the papers' own forms and against physics.

use tautrack::math::vector::{add, cross, dot, scale, sub};
use tautrack::stability::tipover::{Edges, angles, margin};

type Vector = [f64; 3];

/// Contacts counter-clockwise, not level.
const CONTACTS: [Vector; 4] = [
    [-0.3, -0.2, 0.02],
    [0.35, -0.25, -0.03],
    [0.3, 0.2, 0.05],
    [-0.32, 0.25, 0.0],
];
const COG: Vector = [0.05, -0.02, 0.3];

fn unit(vector: Vector) -> Vector {
    scale(1.0 / dot(vector, vector).sqrt(), vector)
}

/// Angle by the definition of Papadopoulos and Rey, with its unit vectors and its contacts
/// clockwise.
fn defined(from: Vector, to: Vector, force: Vector, moment: Vector) -> f64 {
    let a = unit(sub(to, from));
    let across = |v: Vector| sub(v, scale(dot(a, v), a));
    let l = across(sub(to, COG));
    let couple = cross(unit(l), scale(dot(a, moment), a));
    let net = add(across(force), scale(1.0 / dot(l, l).sqrt(), couple));
    let size = unit(l).map(|x| x * dot(net, net).sqrt());
    let angle = (dot(net, unit(l)) / dot(net, net).sqrt())
        .clamp(-1.0, 1.0)
        .acos();
    if dot(cross(net, size), a) > 0.0 {
        angle
    } else {
        -angle
    }
}

#[test]
fn angles_are_those_of_the_definition() {
    for step in 0..200 {
        let turn = f64::from(step) * 0.37;
        let force = [90.0 * turn.sin(), 70.0 * (1.7 * turn).cos(), -120.0];
        let moment = [9.0 * (2.3 * turn).cos(), 12.0 * turn.cos(), 5.0];
        let found = angles(&CONTACTS, COG, force, moment);
        for (edge, got) in found.into_iter().enumerate() {
            // The same edge in clockwise order.
            let want = defined(CONTACTS[(edge + 1) % 4], CONTACTS[edge], force, moment);
            assert!((got - want).abs() < 1e-7, "{step} {edge}: {got} {want}");
        }
    }
}

#[test]
fn one_arc_tangent_gives_the_least_angle() {
    let prepared = Edges::new(&CONTACTS).expect("edges");
    let narrow = |vector: Vector| vector.map(|value| value as f32);
    let single = Edges::new(&CONTACTS.map(narrow)).expect("edges");
    let mut worst = 0.0_f64;
    for step in 0..20_000 {
        let turn = f64::from(step) * 0.37;
        // The force also points upward, and the centre of gravity leaves the support.
        let force = [
            90.0 * turn.sin(),
            70.0 * (1.7 * turn).cos(),
            130.0 * (0.3 * turn).cos(),
        ];
        let moment = [9.0 * (2.3 * turn).cos(), 12.0 * turn.cos(), 5.0];
        let cog = add(
            COG,
            [0.4 * (0.7 * turn).sin(), 0.3 * (1.1 * turn).cos(), 0.0],
        );
        let want = margin(&angles(&CONTACTS, cog, force, moment));
        let got = prepared.margin(cog, force, moment);
        assert!((got - want).abs() < 1e-9, "{step}: {got} {want}");
        let got = f64::from(single.margin(narrow(cog), narrow(force), narrow(moment)));
        // Where a force almost vanishes across the edge, or points almost away from it, the angle
        // is ill-conditioned.
        let net = dot(force, force).sqrt();
        if want.abs() < 3.0 && net > 30.0 {
            worst = worst.max((got - want).abs());
        }
    }
    println!("{worst:e} rad in single precision");
    assert!(worst < 1.5e-6, "{worst:e}");
}

#[test]
fn no_edge_and_no_number_have_no_least_angle() {
    let (force, moment) = ([0.0, 0.0, -100.0], [0.0; 3]);
    let edges = Edges::new(&CONTACTS).expect("edges");
    assert!(edges.margin([f64::NAN, 0.0, 0.3], force, moment).is_nan());
    assert!(edges.margin(COG, [0.0, f64::NAN, 0.0], moment).is_nan());
    assert!(edges.margin(COG, force, [0.0, f64::NAN, 0.0]).is_nan());
    assert_eq!(edges.margin(COG, [0.0; 3], moment), 0.0);
    let none = Edges::<f64, 0>::new(&[]).expect("no edge is bad");
    assert!(none.margin(COG, force, moment).is_nan());
    let mut contacts = CONTACTS;
    contacts[2] = contacts[1];
    assert_eq!(Edges::new(&contacts), None);
    contacts[2][0] = f64::NAN;
    assert_eq!(Edges::new(&contacts), None);
}

#[test]
fn the_margin_is_zero_where_the_moments_about_an_edge_balance() {
    let (from, to) = (CONTACTS[1], CONTACTS[2]);
    let a = unit(sub(to, from));
    let weight = [0.0, 0.0, -100.0];
    let righting = dot(cross(sub(COG, from), weight), a);
    let tipping = |share: f64| {
        let moment = scale(-share * righting, a);
        angles(&CONTACTS, COG, weight, moment)[1]
    };
    assert!(tipping(1.0).abs() < 1e-12, "{}", tipping(1.0));
    assert!(tipping(0.99) > 0.0 && tipping(1.01) < 0.0);
}

#[test]
fn the_margin_is_negative_when_the_cog_is_outside() {
    let outside = [0.5, 0.0, 0.3];
    let found = angles(&CONTACTS, outside, [0.0, 0.0, -100.0], [0.0; 3]);
    assert!(found[1] < 0.0 && margin(&found) == found[1], "{found:?}");
    assert!(
        found[0] > 0.0 && found[2] > 0.0 && found[3] > 0.0,
        "{found:?}"
    );
}

#[test]
fn degenerate_supports_are_never_inside() {
    let weight = [0.0, 0.0, -100.0];
    let doubled = [CONTACTS[0], CONTACTS[1], CONTACTS[1], CONTACTS[3]];
    let within = [-0.1, -0.1, 0.3];
    let found = angles(&doubled, within, weight, [0.0; 3]);
    assert!(
        found[0] > 0.0 && found[2] > 0.0 && found[3] > 0.0,
        "{found:?}"
    );
    assert_eq!(margin(&found), 0.0);
    assert_eq!(angles(&[COG; 3], COG, weight, [0.0; 3]), [0.0; 3]);
    assert_eq!(angles(&CONTACTS, COG, [0.0; 3], [0.0; 3]), [0.0; 4]);
}

#[test]
fn lost_values_stay_lost() {
    let lost = angles(&CONTACTS, COG, [0.0, f64::NAN, -100.0], [0.0; 3]);
    assert!(lost.iter().all(|angle| angle.is_nan()));
    assert!(margin(&[0.5, f64::NAN, 0.4]).is_nan());
    assert!(margin(&[f32::NAN, 0.5]).is_nan() && margin::<f32>(&[]).is_nan());
    assert_eq!(margin(&[0.5, -0.1, 0.2]), -0.1);
}
