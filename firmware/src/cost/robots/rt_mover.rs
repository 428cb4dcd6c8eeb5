//! Counts RT-Mover's guard and its prediction.

use crate::cost::counter::Table;
use crate::cost::guards::{count_guard, still};
use core::hint::black_box;
use tautrack::robots::rt_mover::parameters::Parameters;
use tautrack::robots::rt_mover::prediction::{Prediction, Progress, Way};
use tautrack::robots::rt_mover::wheel::WHEELS;
use tautrack::robots::rt_mover::{RtMover, Shape};

pub fn count(table: &mut Table) -> Option<()> {
    count_prediction(table)?;
    count_guard::<RtMover>(table, "guard tick of RT-Mover", 5, 0.05, still)
}

/// Counts the moments of predictions, which are in addition to the guard's tick. Each prediction
/// runs to its end, then another one starts.
fn count_prediction(table: &mut Table) -> Option<()> {
    const WAY: Way<f32> = Way {
        rise: 0.2,
        travel: 0.15,
        fall: 0.03,
    };
    let parameters = black_box(Parameters::nominal());
    table.kernel(
        "moment of RT-Mover's prediction",
        &mut (parameters, None, Progress::Unfinished),
        |(parameters, prediction, progress), call, random| {
            if prediction.is_none() || *progress != Progress::Unfinished {
                let shape = Shape {
                    pitch: random.within(0.1),
                    steering: [random.within(0.2), random.within(0.5)],
                    roll: random.near([0.0; 2], 0.2),
                };
                let (heading, wheel) = (random.within(0.2), WHEELS[(call & 3) as usize]);
                *prediction = Some(Prediction::new(parameters, &shape, heading, wheel, &WAY));
            }
        },
        |(parameters, prediction, progress)| {
            if let Some(prediction) = prediction {
                *progress = prediction.moment(parameters);
            }
        },
    )
}
