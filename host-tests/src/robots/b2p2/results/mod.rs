//! The results of B2P2: the zero moment point of its paper, and its parts of the page.

mod moment;
mod page;

use super::plant::B2p2Parameters;
use super::section::B2p2;
use crate::results::report::OwnPage;
use crate::results::robot::Results;
use crate::results::zmp::OwnBalance;
use moment::{joints, model, moment};

/// Length of the straight robot, pulleys included, m.
pub fn length(parameters: &B2p2Parameters) -> f64 {
    parameters.l1 + parameters.taut_length(0.0) + 2.0 * parameters.pulley_radius
}

impl Results for B2p2 {
    fn balance(&self, friction: f64) -> Option<OwnBalance> {
        let parameters = self.parameters(friction);
        let payload = parameters.payload;
        let loaded_from_s = payload.map_or(f64::INFINITY, |load| load.from_time_s);
        let models = [None, payload].map(|payload| model(&parameters, payload));
        Some(OwnBalance {
            moment: Box::new(move |time_s, around| {
                let model = models[usize::from(time_s >= loaded_from_s)].as_ref()?;
                Some(moment(model, around[1], around.map(joints)))
            }),
            length_m: length(&parameters),
        })
    }

    fn page(&self, friction: f64) -> Option<OwnPage> {
        Some(page::page(self, &self.parameters(friction)))
    }
}
