//! Tests the state q: validity, ages and which readings move it.

use crate::framed;
use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::estimate::position::GATE;
use tautrack::estimate::state::{Estimator, Joint, Validity};
use tautrack::settings::Settings;
use tautrack::stability::attitude::Attitude;

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
