//! Tests supports that are small, sloping or incomplete.

use tautrack::stability::support::{Edge, NO_EDGE, Stance, margins, narrowest};

/// A square with this side, whose front is higher by `rise`.
fn square(side: f32, rise: f32) -> [[f32; 3]; 4] {
    [
        [0.0, 0.0, 0.0],
        [side, 0.0, rise],
        [side, side, rise],
        [0.0, side, 0.0],
    ]
}

#[test]
fn an_edge_of_three_centimetres_has_a_direction() {
    let contacts = square(0.03, 0.0);
    for margin in Stance::on(contacts, [0.015, 0.015, 0.2]).margins() {
        assert!((margin - 0.015).abs() < 1e-6, "{margin}");
    }
}

#[test]
fn a_support_of_one_point_is_as_far_away_as_the_point() {
    for (x, y, distance) in [(0.3, 0.4, 0.5), (-0.1, 0.0, 0.1), (0.0, 0.0, 0.0)] {
        for margin in Stance::on([[0.0; 3]; 4], [x, y, 0.2]).margins() {
            assert!((margin + distance).abs() < 1e-6, "{margin} {distance}");
        }
    }
}

#[test]
fn margins_of_four_contacts_are_those_of_the_stance_on_them() {
    let contacts = [
        [0.0, -0.2, 0.0],
        [0.8, -0.15, 0.0],
        [0.75, 0.2, 0.1],
        [0.05, 0.25, 0.0],
    ];
    let cog = [0.3, 0.05, 0.4];
    assert_eq!(margins(&contacts, cog), Stance::on(contacts, cog).margins());
}

#[test]
fn a_stance_tells_which_contacts_are_on_the_ground() {
    for raised in 0..4 {
        let mut contacts = square(0.4, 0.0).map(Some);
        contacts[raised] = None;
        let standing = Stance::on_some(contacts, [0.2, 0.2, 0.3]).standing();
        assert_eq!(standing, [0, 1, 2, 3].map(|contact| contact != raised));
    }
}

#[test]
fn the_direction_of_a_support_is_that_of_its_slope() {
    // A rise of 3 in 5.
    for side in [0.03, 0.4] {
        for sign in [-1.0, 1.0_f32] {
            let stance = Stance::on(square(side * 0.8, sign * side * 0.6), [0.0; 3]);
            let [cosine, sine] = stance.along();
            assert!((cosine - 0.8).abs() < 1e-6 && (sine - sign * 0.6).abs() < 1e-6);
            let level = sign < 0.0;
            assert_eq!(stance.rising() == [1.0, 0.0], level);
        }
    }
}

#[test]
fn a_support_without_length_is_level() {
    let stance = Stance::on(square(1e-4, 5e-4), [0.0; 3]);
    assert_eq!(stance.along(), [1.0, 0.0]);
}

#[test]
fn the_narrowest_margin_is_the_one_that_is_not_known() {
    assert_eq!(narrowest(&[0.1, 0.3, 0.05, 0.2]), Edge::Left);
    assert_eq!(narrowest(&[0.1, f32::NAN, 0.05, 0.2]), Edge::Front);
    assert_eq!(narrowest(&[f32::NAN, 0.3, 0.05, 0.2]), Edge::Back);
    assert_eq!(narrowest(&[0.1, NO_EDGE, 0.3, -NO_EDGE]), Edge::Right);
}
