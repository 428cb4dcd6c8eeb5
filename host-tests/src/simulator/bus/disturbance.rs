//! Faults of the bus. They are reproducible: each decision depends only on a seed and the number of
//! the frame.

use tautrack::can::Frame;

/// Faults that change or lose frames on the wire. Cut-off participants are handled elsewhere.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Disturbance {
    loss: Option<Loss>,
    flip: Option<Flip>,
}

#[derive(Clone, Copy, Debug)]
struct Loss {
    /// Frames whose number hashes below this value are lost: the probability times 2^64.
    threshold: u64,
    seed: u64,
}

#[derive(Clone, Copy, Debug)]
struct Flip {
    id: Option<u16>,
    /// Number of frames with the identifier before the one that is changed.
    frames_before: u64,
    bit: u8,
}

impl Disturbance {
    pub(super) fn lose(&mut self, probability: f64, seed: u64) {
        // The cast saturates and turns NaN into zero. With probability 1, every frame is lost
        // except one in 2^64.
        let threshold = (probability * 2_f64.powi(64)) as u64;
        self.loss = (threshold > 0).then_some(Loss { threshold, seed });
    }

    pub(super) fn flip(&mut self, id: Option<u16>, frames_before: u64, bit: u8) {
        self.flip = Some(Flip {
            id,
            frames_before,
            bit,
        });
    }

    /// Returns frame number `number` as it is received; `None` if it is lost.
    pub(super) fn apply(&mut self, frame: Frame, number: u64) -> Option<Frame> {
        if self
            .loss
            .is_some_and(|loss| mix(loss.seed ^ mix(number)) < loss.threshold)
        {
            return None;
        }
        let counts = |flip: &&mut Flip| flip.id.is_none_or(|id| id == frame.id());
        let Some(flip) = self.flip.as_mut().filter(counts) else {
            return Some(frame);
        };
        if flip.frames_before > 0 {
            flip.frames_before -= 1;
            return Some(frame);
        }
        let flipped = with_flipped_bit(&frame, flip.bit);
        if flipped.is_some() {
            self.flip = None;
        }
        flipped.or(Some(frame))
    }
}

fn with_flipped_bit(frame: &Frame, bit: u8) -> Option<Frame> {
    let mut data = [0; 8];
    let length = frame.data().len();
    data[..length].copy_from_slice(frame.data());
    *data[..length].get_mut(usize::from(bit / 8))? ^= 1 << (bit % 8);
    Frame::new(frame.id(), &data[..length])
}

/// Output function of `SplitMix64` (Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators"): a bijection of 64 bits in which every input bit changes about half of the output
/// bits.
fn mix(counter: u64) -> u64 {
    let mut z = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
