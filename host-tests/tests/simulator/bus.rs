//! Tests that the virtual bus keeps the rules of CAN for any traffic.

use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::BTreeMap;
use tautrack::can::Frame;
use tautrack_host_tests::simulator::bus::arbitration::QUEUE_CAPACITY;
use tautrack_host_tests::simulator::bus::wire::{BITS_PER_STEP, worst_case_bits};
use tautrack_host_tests::simulator::bus::{Bus, Collision, Delivered};

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

fn ids(delivered: &[Delivered]) -> Vec<u16> {
    delivered.iter().map(|d| d.frame.id()).collect()
}

/// Length of a frame on the wire, found by stuffing actual bits: after five equal bits, including
/// stuff bits, one opposite bit is inserted. `bits` are the bits subject to stuffing, from start of
/// frame to CRC.
fn stuffed_length(bits: &[bool]) -> u32 {
    let (mut length, mut last, mut run) = (0, None, 0);
    for bit in bits {
        run = if last == Some(*bit) { run + 1 } else { 1 };
        last = Some(*bit);
        length += 1;
        if run == 5 {
            length += 1;
            last = Some(!bit);
            run = 1;
        }
    }
    // CRC delimiter, acknowledge slot and delimiter, end of frame, interframe space.
    length + 1 + 2 + 7 + 3
}

#[test]
fn worst_case_is_reached_by_the_worst_bits_and_by_no_other() {
    for length in 0..=8 {
        let stuffable = 34 + 8 * length;
        // Five equal bits, then groups of four with alternating polarity: the stuff bit before each
        // group completes its run of five.
        let worst: Vec<bool> = (0..stuffable)
            .map(|i| i >= 1 && ((i - 1) / 4) % 2 == 1)
            .collect();
        let expected = stuffed_length(&worst);
        let bits = worst_case_bits(&frame(0, &vec![0; length]));
        assert_eq!(bits, expected, "{length} bytes");
    }
    assert_eq!(worst_case_bits(&frame(0, &[0; 8])), 135);
    assert_eq!(worst_case_bits(&frame(0, &[])), 55);
}

proptest! {
    #[test]
    fn no_bits_stuff_to_more_than_the_worst_case(length in 0_usize..=8, bits in vec(any::<bool>(), 98)) {
        let worst = worst_case_bits(&frame(0, &vec![0; length]));
        prop_assert!(stuffed_length(&bits[..34 + 8 * length]) <= worst);
    }
}

#[test]
fn lowest_identifier_goes_first_whoever_sends_it() {
    let mut bus = Bus::new(3);
    for (participant, id) in [(0, 0x300), (1, 0x080), (2, 0x181)] {
        bus.offer(participant, frame(id, &[1; 8])).unwrap();
    }
    assert_eq!(ids(bus.step()), [0x080, 0x181, 0x300]);
}

#[test]
fn oldest_frame_of_a_participant_goes_first_even_with_a_high_identifier() {
    let mut bus = Bus::new(2);
    bus.offer(0, frame(0x700, &[])).unwrap();
    bus.offer(0, frame(0x001, &[])).unwrap();
    bus.offer(1, frame(0x200, &[])).unwrap();
    assert_eq!(ids(bus.step()), [0x200, 0x700, 0x001]);
}

#[test]
fn every_participant_but_the_sender_receives_a_frame() {
    let mut bus = Bus::new(3);
    bus.offer(1, frame(0x181, &[7])).unwrap();
    bus.step();
    let received: Vec<usize> = (0..3).map(|p| bus.received_by(p).count()).collect();
    assert_eq!(received, [1, 0, 1]);
}

#[test]
fn a_frame_that_has_begun_is_finished_before_a_better_identifier() {
    let mut bus = Bus::new(2);
    for _ in 0..8 {
        bus.offer(0, frame(0x300, &[0; 8])).unwrap();
    }
    // 7 frames of 135 bits end within 1000 bits; of the eighth frame, 55 bits are sent.
    assert_eq!(bus.step().len(), 7);
    bus.offer(1, frame(0x001, &[0; 8])).unwrap();
    let delivered = bus.step();
    assert_eq!(ids(delivered), [0x300, 0x001]);
    assert_eq!(
        delivered
            .iter()
            .map(|d| d.latency_steps)
            .collect::<Vec<_>>(),
        [2, 1]
    );
    // The eighth frame ends 80 bits into the second step, the other one 135 bits later.
    let worst: BTreeMap<u16, f64> = bus.figures().worst_latency_by_id_ms().collect();
    assert_eq!(worst, BTreeMap::from([(0x001, 0.215), (0x300, 1.080)]));
    assert_eq!(bus.figures().worst_latency_ms(), 1.080);
}

#[test]
fn load_is_that_of_the_bits_on_the_wire() {
    let mut bus = Bus::new(2);
    for step in 0..200 {
        if step < 50 {
            bus.offer(0, frame(0x100, &[0; 8])).unwrap();
            bus.offer(0, frame(0x100, &[])).unwrap();
        }
        bus.step();
        if step == 0 {
            assert_eq!(bus.figures().step_load(), 0.190);
        }
    }
    let figures = bus.figures();
    assert_eq!(figures.busiest_step_load(), 0.190);
    assert_eq!(figures.busiest_window_load(), 0.095);
    assert_eq!(figures.window_load(), 0.0);
    assert_eq!(figures.mean_load(), 0.0475);
    assert_eq!((figures.frames(), figures.deepest_queue()), (100, 2));
}

#[test]
fn two_senders_of_one_identifier_are_reported() {
    let mut bus = Bus::new(3);
    bus.offer(2, frame(0x181, &[1])).unwrap();
    bus.offer(0, frame(0x181, &[2])).unwrap();
    assert_eq!(bus.step().len(), 2);
    let collision = Collision {
        id: 0x181,
        participants: [0, 2],
    };
    assert_eq!(bus.collisions(), [collision]);
    assert!(
        collision
            .to_string()
            .contains("participants 0 and 2 both send identifier 0x181")
    );
    bus.step();
    assert_eq!(bus.collisions(), []);
    assert_eq!(bus.figures().collisions(), 1);
}

#[test]
fn a_full_queue_names_its_participant() {
    let mut bus = Bus::new(4);
    for _ in 0..QUEUE_CAPACITY {
        bus.offer(3, frame(0x10, &[])).unwrap();
    }
    assert_eq!(bus.room(3), 0);
    let overflow = bus.offer(3, frame(0x123, &[])).unwrap_err();
    assert_eq!((overflow.participant, overflow.id), (3, 0x123));
    assert!(
        overflow
            .to_string()
            .starts_with("participant 3 has 64 frames waiting")
    );
    assert_eq!(bus.room(2), QUEUE_CAPACITY);
}

#[test]
fn a_participant_that_is_cut_off_neither_sends_nor_receives() {
    let mut bus = Bus::new(3);
    bus.offer(0, frame(0x10, &[])).unwrap();
    bus.cut_off(0);
    bus.offer(0, frame(0x11, &[])).unwrap();
    bus.offer(1, frame(0x12, &[])).unwrap();
    assert_eq!(ids(bus.step()), [0x12]);
    assert_eq!(bus.received_by(0).count(), 0);
    assert_eq!(bus.figures().lost(), 2);

    bus.reconnect(0);
    bus.offer(0, frame(0x13, &[])).unwrap();
    bus.offer(1, frame(0x14, &[])).unwrap();
    assert_eq!(ids(bus.step()), [0x13, 0x14]);
    assert_eq!(bus.received_by(0).count(), 1);
}

#[test]
fn a_frame_dies_with_its_sender_on_the_wire() {
    let mut bus = Bus::new(2);
    for _ in 0..8 {
        bus.offer(0, frame(0x300, &[0; 8])).unwrap();
    }
    bus.step();
    bus.cut_off(0);
    assert_eq!(bus.step(), []);
    assert_eq!(bus.figures().lost(), 1);
}

#[test]
fn lost_frames_follow_from_the_seed_in_the_asked_share() {
    let lost = |probability, seed| {
        let mut bus = Bus::new(2);
        bus.lose_frames(probability, seed);
        (0..20_000)
            .map(|_| {
                bus.offer(0, frame(0x1, &[])).unwrap();
                bus.step().is_empty()
            })
            .collect::<Vec<_>>()
    };
    let count = |lost: &[bool]| lost.iter().filter(|l| **l).count() as f64;
    let first = lost(0.1, 1);
    // Binomial distribution with 20000 trials: four standard deviations are 170.
    assert!((count(&first) - 2_000.0).abs() < 170.0, "{}", count(&first));
    assert_eq!(first, lost(0.1, 1));
    let second = lost(0.1, 2);
    assert!(
        (count(&second) - 2_000.0).abs() < 170.0,
        "{}",
        count(&second)
    );
    let both = first
        .iter()
        .zip(&second)
        .filter(|(a, b)| **a && **b)
        .count() as f64;
    assert!(
        (both - 200.0).abs() < 60.0,
        "seeds are not independent: {both} lost with both"
    );
    assert_eq!(count(&lost(1.0, 3)), 20_000.0);
    assert_eq!(count(&lost(0.0, 3)), 0.0);
    assert_eq!(count(&lost(f64::NAN, 3)), 0.0);
}

#[test]
fn one_bit_flips_in_the_first_frame_that_has_it() {
    let mut bus = Bus::new(2);
    bus.flip_bit(None, 1, 12);
    let sent = [
        frame(1, &[0; 8]),
        frame(2, &[0]),
        frame(3, &[0; 2]),
        frame(4, &[0; 8]),
    ];
    for frame in sent {
        bus.offer(0, frame).unwrap();
    }
    let received: Vec<Frame> = bus.step().iter().map(|d| d.frame).collect();
    assert_eq!(received, [sent[0], sent[1], frame(3, &[0, 0x10]), sent[3]]);
}

#[test]
fn a_bit_flips_only_in_a_frame_with_the_chosen_identifier() {
    let mut bus = Bus::new(2);
    bus.flip_bit(Some(2), 1, 0);
    let sent = [
        frame(1, &[0]),
        frame(2, &[0]),
        frame(2, &[0]),
        frame(2, &[0]),
    ];
    for frame in sent {
        bus.offer(0, frame).unwrap();
    }
    let received: Vec<Frame> = bus.step().iter().map(|d| d.frame).collect();
    assert_eq!(received, [sent[0], sent[1], frame(2, &[1]), sent[3]]);
}

/// Traffic of four participants: the frames offered in each step, as participant, identifier and
/// length.
fn traffic() -> impl Strategy<Value = Vec<Vec<(usize, u16, usize)>>> {
    vec(vec((0_usize..4, 0_u16..0x200, 0_usize..=8), 0..12), 1..80)
}

proptest! {
    #[test]
    fn nothing_is_lost_doubled_reordered_or_faster_than_the_wire(steps in traffic()) {
        let mut bus = Bus::new(4);
        let mut offered: BTreeMap<u16, Vec<(u64, Frame)>> = BTreeMap::new();
        let mut received: BTreeMap<u16, Vec<(u64, Frame)>> = BTreeMap::new();
        let (mut number, mut now, mut bits_offered, mut bits_received) = (0_u32, 0_u64, 0_u64, 0_u64);
        let mut traffic = steps.into_iter();
        loop {
            let offers = traffic.next();
            if offers.is_none() && (0..4).all(|p| bus.queue_depth(p) == 0) && bits_received == bits_offered {
                break;
            }
            for (participant, id, length) in offers.into_iter().flatten() {
                // Each identifier belongs to one participant, as on a correctly planned bus.
                let id = id * 4 + participant as u16;
                let mut data = [0; 8];
                data[..4].copy_from_slice(&number.to_le_bytes());
                number += 1;
                let frame = frame(id, &data[..length]);
                if bus.offer(participant, frame).is_ok() {
                    offered.entry(id).or_default().push((now, frame));
                    bits_offered += u64::from(worst_case_bits(&frame));
                } else {
                    prop_assert_eq!(bus.room(participant), 0);
                }
            }
            let backlog = bits_offered - bits_received;
            let busy: u64 = bus.step().iter().map(|d| {
                received.entry(d.frame.id()).or_default().push((now + 1 - d.latency_steps, d.frame));
                u64::from(worst_case_bits(&d.frame))
            }).sum();
            bits_received += busy;
            now += 1;
            prop_assert!(bits_received <= now * u64::from(BITS_PER_STEP));
            // The bus is never idle while a frame waits: the rest of a step's work is at most one
            // unfinished frame.
            prop_assert!(busy + 135 > backlog.min(u64::from(BITS_PER_STEP)));
            prop_assert!(bus.collisions().is_empty());
            prop_assert!(now < 1_000, "the bus does not drain");
        }
        prop_assert_eq!(offered, received);
        let expected = bits_offered as f64 / (now * u64::from(BITS_PER_STEP)) as f64;
        prop_assert!((bus.figures().mean_load() - expected).abs() < 1e-12);
    }
}
