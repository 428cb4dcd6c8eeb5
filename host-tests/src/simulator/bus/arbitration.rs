//! Virtual CAN bus with arbitration: the oldest frame of each participant competes, the lowest
//! identifier wins, and no frame is interrupted.

use super::disturbance::Disturbance;
use super::figures::Figures;
use super::wire::{BITS_PER_STEP, worst_case_bits};
use std::collections::VecDeque;
use std::fmt;
use tautrack::can::Frame;

/// Maximum number of frames that one participant can have waiting: as many as the link carries in
/// two steps.
pub const QUEUE_CAPACITY: usize = 2 * tautrack::link::MAX_FRAMES;

/// Frame that was delivered to its receivers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Delivered {
    /// The frame as received.
    pub frame: Frame,
    /// Participant that sent it. All other connected participants receive it.
    pub sender: usize,
    /// Number of steps from the one in which the frame was offered to the one in which it is
    /// received; at least 1.
    pub latency_steps: u64,
}

/// Error of the bus plan: two participants started to send the same identifier at the same time. On
/// a real bus their data bits would collide, and both would repeat the frame until one gives up.
/// Here both frames are sent one after the other, that of the lower participant first, and the
/// collision is reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Collision {
    /// Identifier that both used.
    pub id: u16,
    /// The two participants, in the order in which their frames are sent.
    pub participants: [usize; 2],
}

impl fmt::Display for Collision {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [first, second] = self.participants;
        let id = self.id;
        write!(
            f,
            "participants {first} and {second} both send identifier {id:#05x}"
        )
    }
}

/// Error: a participant offers more frames than the bus can carry.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Overflow {
    /// Participant whose queue is full.
    pub participant: usize,
    /// Identifier of the frame that did not fit into the queue and is not sent.
    pub id: u16,
}

impl fmt::Display for Overflow {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { participant, id } = self;
        write!(
            f,
            "participant {participant} has {QUEUE_CAPACITY} frames waiting for the bus; {id:#05x} found no place"
        )
    }
}

impl std::error::Error for Overflow {}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    frame: Frame,
    offered_at: u64,
}

#[derive(Clone, Debug, Default)]
struct Participant {
    queue: VecDeque<Waiting>,
    cut_off: bool,
}

/// Frame that is being sent and is not complete.
#[derive(Clone, Copy, Debug)]
struct InFlight {
    sender: usize,
    waiting: Waiting,
    bits_left: u32,
}

/// Classic CAN bus at 1 Mbit/s. Participants offer frames between two steps and receive them after
/// the next step.
///
/// Participants are numbered from 0. Methods panic if the number is not on the bus.
#[derive(Debug)]
pub struct Bus {
    participants: Vec<Participant>,
    in_flight: Option<InFlight>,
    delivered: Vec<Delivered>,
    collisions: Vec<Collision>,
    disturbance: Disturbance,
    transferred: u64,
    figures: Figures,
}

impl Bus {
    /// Creates an idle bus with `participants` participants.
    pub fn new(participants: usize) -> Self {
        Self {
            participants: vec![Participant::default(); participants],
            in_flight: None,
            delivered: Vec::new(),
            collisions: Vec::new(),
            disturbance: Disturbance::default(),
            transferred: 0,
            figures: Figures::default(),
        }
    }

    /// Appends `frame` to the queue of `participant`; it can be sent from the next step on.
    ///
    /// # Errors
    /// [`Overflow`] if [`QUEUE_CAPACITY`] frames are already waiting; the frame is dropped.
    pub fn offer(&mut self, participant: usize, frame: Frame) -> Result<(), Overflow> {
        let Participant { queue, cut_off } = &mut self.participants[participant];
        if *cut_off {
            self.figures.count_loss();
            return Ok(());
        }
        if queue.len() >= QUEUE_CAPACITY {
            let id = frame.id();
            return Err(Overflow { participant, id });
        }
        queue.push_back(Waiting {
            frame,
            offered_at: self.figures.steps(),
        });
        self.figures.count_queue(queue.len());
        Ok(())
    }

    /// Runs one step and returns the frames received in it, in the order of the wire.
    ///
    /// The bus carries exactly [`BITS_PER_STEP`]; a frame that is not complete continues in the
    /// next step.
    pub fn step(&mut self) -> &[Delivered] {
        self.delivered.clear();
        self.collisions.clear();
        let mut bits_left = BITS_PER_STEP;
        while let Some(mut sending) = self.in_flight.take().or_else(|| self.arbitrate()) {
            let sent = sending.bits_left.min(bits_left);
            bits_left -= sent;
            sending.bits_left -= sent;
            if sending.bits_left > 0 {
                self.in_flight = Some(sending);
                break;
            }
            self.deliver(&sending, BITS_PER_STEP - bits_left);
            if bits_left == 0 {
                break;
            }
        }
        self.figures.count_step(BITS_PER_STEP - bits_left);
        &self.delivered
    }

    /// Frames that `participant` received in the last step: all except its own; none while it is
    /// cut off.
    pub fn received_by(&self, participant: usize) -> impl Iterator<Item = &Delivered> {
        let cut_off = self.participants[participant].cut_off;
        self.delivered
            .iter()
            .filter(move |delivered| !cut_off && delivered.sender != participant)
    }

    /// Collisions of the last step: identifiers that two participants used at the same time.
    pub fn collisions(&self) -> &[Collision] {
        &self.collisions
    }

    /// Number of frames that `participant` has waiting, without the one being sent.
    pub fn queue_depth(&self, participant: usize) -> usize {
        self.participants[participant].queue.len()
    }

    /// Number of frames that `participant` can still offer without an [`Overflow`].
    pub fn room(&self, participant: usize) -> usize {
        QUEUE_CAPACITY - self.queue_depth(participant)
    }

    /// Load and latency since the start of the run.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Disconnects `participant`: from now on it receives nothing, and the frames that it has
    /// waiting or offers are lost.
    pub fn cut_off(&mut self, participant: usize) {
        let Participant { queue, cut_off } = &mut self.participants[participant];
        *cut_off = true;
        for _ in queue.drain(..) {
            self.figures.count_loss();
        }
        if self
            .in_flight
            .take_if(|frame| frame.sender == participant)
            .is_some()
        {
            self.figures.count_loss();
        }
    }

    /// Reconnects `participant`.
    pub fn reconnect(&mut self, participant: usize) {
        self.participants[participant].cut_off = false;
    }

    /// Loses each frame on the wire with `probability` (0 to 1; 0 ends the loss). A lost frame
    /// still takes its time on the bus. Equal seeds lose the same frames.
    pub fn lose_frames(&mut self, probability: f64, seed: u64) {
        self.disturbance.lose(probability, seed);
    }

    /// Flips data bit `bit` (0 is the lowest of byte 0) in one frame with this identifier (`None`:
    /// with any): the first frame that has this bit, after `frames_before` other ones.
    pub fn flip_bit(&mut self, id: Option<u16>, frames_before: u64, bit: u8) {
        self.disturbance.flip(id, frames_before, bit);
    }

    /// Selects the next frame: the oldest frame of each participant competes, and the one with the
    /// lowest identifier is removed from its queue.
    fn arbitrate(&mut self) -> Option<InFlight> {
        let heads = self.participants.iter().enumerate();
        let mut heads = heads.filter_map(|(number, participant)| {
            let head = participant.queue.front()?;
            Some((head.frame.id(), number))
        });
        let mut winner = heads.next()?;
        let mut rival = None;
        for head in heads {
            if head.0 < winner.0 {
                winner = head;
                rival = None;
            } else if head.0 == winner.0 && rival.is_none() {
                rival = Some(head.1);
            }
        }
        let (id, sender) = winner;
        if let Some(rival) = rival {
            let participants = [sender, rival];
            self.collisions.push(Collision { id, participants });
            self.figures.count_collision();
        }
        let waiting = self.participants[sender].queue.pop_front()?;
        Some(InFlight {
            sender,
            waiting,
            bits_left: worst_case_bits(&waiting.frame),
        })
    }

    /// Delivers a frame whose last bit is number `end_bit` of this step.
    fn deliver(&mut self, sent: &InFlight, end_bit: u32) {
        let number = self.transferred;
        self.transferred += 1;
        let InFlight {
            sender, waiting, ..
        } = *sent;
        let Some(frame) = self.disturbance.apply(waiting.frame, number) else {
            self.figures.count_loss();
            return;
        };
        let whole_steps = self.figures.steps() - waiting.offered_at;
        let latency_us = whole_steps * u64::from(BITS_PER_STEP) + u64::from(end_bit);
        self.figures.count_delivery(frame.id(), latency_us);
        self.delivered.push(Delivered {
            frame,
            sender,
            latency_steps: whole_steps + 1,
        });
    }
}
