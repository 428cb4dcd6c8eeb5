//! Computes the tensions of a belt from its material: how much of it lies in each section between
//! pulley 1 and the corners of the ground.
//!
//! Pulley 1 drives the belt without slip. A corner holds the belt by friction as long as the
//! tensions on its two sides differ by less than the capstan ratio `exp(friction * bend)` (Euler,
//! Eytelwein). Beyond that, material slides over the corner until they do. The other pulleys turn
//! freely, so a section has one tension.

use super::path::{Corner, Section};
use crate::world::physics::DT;

/// Sections shorter than this stretch as if they had this length, m. The stiffness of a shorter one
/// would need a shorter step.
const SHORTEST: f64 = 0.2;
/// Time by which the tension leads the length: a step, because the tension belongs to the length at
/// the end of the step, and 2 ms for the losses of the belt's material (assumed), s.
pub const LEAD: f64 = DT + 2.0e-3;
/// Number of times that the tensions at all corners are balanced in one step.
const SWEEPS: usize = 4;

/// Elastic belt.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Elasticity {
    /// Force that would stretch the belt to twice its length, N.
    pub stiffness: f64,
    /// Length of the belt without tension, without the half turn behind pulley 1, m.
    pub length: f64,
}

/// Where the material of a belt is.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Corners that touch the belt, with the length of unstretched belt from the lowest point of
    /// pulley 1 to the corner, m.
    corners: Vec<(usize, f64)>,
}

/// State of a section in one step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Strain {
    /// Tension, N; negative if the section is slack.
    pub tension: f64,
    /// Rise of the tension for each metre of belt that leaves the section, N/m.
    pub stiffness: f64,
}

/// Corner that touches the belt.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Touch {
    /// The corner.
    pub corner: Corner,
    /// Speed at which the belt slides over the corner towards pulley 1, m/s.
    pub sliding: f64,
}

impl Material {
    /// Returns the tension of each section, N, none of them negative, and the corners.
    ///
    /// `fed` is the length of belt that pulley 1 has taken from the first section in this step and
    /// given to the last one, m. `rates` are the speeds at which the sections become longer, m/s.
    pub fn tensions(
        &mut self,
        belt: &Elasticity,
        sections: &[Section],
        rates: &[f64],
        radius: f64,
        fed: f64,
        friction: f64,
    ) -> (Vec<f64>, Vec<Touch>) {
        let lengths: Vec<f64> = sections
            .iter()
            .zip(rates)
            .map(|(section, rate)| section.length(radius) + rate * LEAD)
            .collect();
        self.follow(belt, sections, &lengths, fed);
        let mut strains = self.strains(belt, &lengths);
        let mut touches: Vec<Touch> = sections
            .iter()
            .filter_map(|section| section.ends_at)
            .map(|(corner, _)| Touch {
                corner,
                sliding: 0.0,
            })
            .collect();
        for _ in 0..SWEEPS {
            for (index, touch) in touches.iter_mut().enumerate() {
                let bend = sections[index].ends_at.map_or(0.0, |(_, bend)| bend);
                let ratio = libm::exp(friction * bend);
                let slid = slide([strains[index], strains[index + 1]], ratio);
                self.corners[index].1 += slid;
                strains[index].tension -= strains[index].stiffness * slid;
                strains[index + 1].tension += strains[index + 1].stiffness * slid;
                touch.sliding += slid / DT;
            }
        }
        let tensions = strains
            .iter()
            .map(|strain| strain.tension.max(0.0))
            .collect();
        (tensions, touches)
    }

    /// Takes the present corners. Material at a corner that touched the belt before stays there. At
    /// a new corner the belt has the tension of the section that the corner divides.
    fn follow(&mut self, belt: &Elasticity, sections: &[Section], lengths: &[f64], fed: f64) {
        let before: Vec<(usize, f64)> = self
            .corners
            .drain(..)
            .map(|(edge, material)| (edge, material - fed))
            .collect();
        let touching = sections.iter().filter_map(|section| section.ends_at);
        let (mut walked, mut start) = (0.0, (0.0, 0.0));
        for (index, (corner, _)) in touching.enumerate() {
            walked += lengths[index];
            let kept = before.iter().find(|(edge, _)| *edge == corner.edge);
            let material = kept.map_or_else(
                || {
                    // From the corner before to the next one that stays, or to the end.
                    let end = next_kept(belt, sections, lengths, &before, index);
                    let part = (walked - start.0) / (end.0 - start.0);
                    start.1 + part * (end.1 - start.1)
                },
                |(_, material)| *material,
            );
            start = (walked, material);
            self.corners.push((corner.edge, material));
        }
    }

    /// Strain of each section without sliding.
    fn strains(&self, belt: &Elasticity, lengths: &[f64]) -> Vec<Strain> {
        let ends = self.corners.iter().map(|(_, material)| *material);
        let mut begin = 0.0;
        ends.chain([belt.length])
            .zip(lengths)
            .map(|(end, length)| {
                let material = end - begin;
                begin = end;
                let stiffness = belt.stiffness / material.max(SHORTEST);
                Strain {
                    tension: (length - material) * stiffness,
                    stiffness,
                }
            })
            .collect()
    }
}

/// Returns the length along the path and the material at the first corner behind `index` that
/// touched the belt before; at the end of the path if there is none.
fn next_kept(
    belt: &Elasticity,
    sections: &[Section],
    lengths: &[f64],
    before: &[(usize, f64)],
    index: usize,
) -> (f64, f64) {
    let mut walked: f64 = lengths[..=index].iter().sum();
    for (section, length) in sections.iter().zip(lengths).skip(index + 1) {
        walked += length;
        let Some((corner, _)) = section.ends_at else {
            break;
        };
        if let Some((_, material)) = before.iter().find(|(edge, _)| *edge == corner.edge) {
            return (walked, *material);
        }
    }
    (walked, belt.length)
}

/// Length of belt that slides over a corner from the section behind it to the section before it, so
/// that their tensions differ by no more than `ratio`, m; negative if it slides the other way.
fn slide([before, behind]: [Strain; 2], ratio: f64) -> f64 {
    let towards = |tight: Strain, loose: Strain| {
        if tight.tension <= ratio * loose.tension.max(0.0) {
            return 0.0;
        }
        let balanced =
            (tight.tension - ratio * loose.tension) / (tight.stiffness + ratio * loose.stiffness);
        // A section that is slack gives until nothing pulls any more.
        balanced.min(tight.tension / tight.stiffness)
    };
    towards(before, behind) - towards(behind, before)
}
