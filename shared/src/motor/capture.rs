//! Records signals of the PWM interrupt: up to four signals, 512 samples each, at the PWM rate or a
//! part of it.
//!
//! A client starts a recording at once, or arms it for a fault. An armed recording runs in a ring,
//! so that it has samples from before the fault. 4 KiB of RAM hold the samples.

use super::bridge::{PowerStage, Readings};

/// Samples of one recording.
pub const SAMPLES: usize = 512;
/// Signals of one recording.
pub const CHANNELS: usize = 4;
/// Samples in one window of [`Capture::window`].
pub const WINDOW: usize = 64;

/// One sample: the value of each channel.
pub type Sample = [i16; CHANNELS];

/// Signals that can be recorded. Their codes are those of object 0x2060.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Signal {
    /// Nothing; the value is 0.
    None = 0,
    /// Current out of half bridge a; 2^15 is the full scale of the board.
    CurrentA = 1,
    /// Current out of half bridge b.
    CurrentB = 2,
    /// Current along the flux of the magnets; 0 for a brushed motor.
    CurrentD = 3,
    /// Current that makes the torque.
    CurrentQ = 4,
    /// Demand for the current that makes the torque.
    Demand = 5,
    /// Compare value of half bridge a; 0 while the bridge is not driven.
    CompareA = 6,
    /// Compare value of half bridge b.
    CompareB = 7,
    /// Compare value of half bridge c.
    CompareC = 8,
    /// The low 16 bits of the rotor sensor's count.
    Rotor = 9,
    /// Velocity of the output shaft, 0.01 rad/s, as the control task estimated it last.
    Velocity = 10,
}

impl Signal {
    /// Returns the signal with this code. Another code records nothing.
    pub fn from_code(code: u8) -> Self {
        match code {
            1 => Self::CurrentA,
            2 => Self::CurrentB,
            3 => Self::CurrentD,
            4 => Self::CurrentQ,
            5 => Self::Demand,
            6 => Self::CompareA,
            7 => Self::CompareB,
            8 => Self::CompareC,
            9 => Self::Rotor,
            10 => Self::Velocity,
            _ => Self::None,
        }
    }
}

/// Values of all signals in one PWM period.
#[derive(Clone, Copy, Debug)]
pub struct Signals {
    /// What the board measured.
    pub readings: Readings,
    /// What it does in the next period.
    pub stage: PowerStage,
    /// Currents of half bridges a and b, of the axes d and q, and the demand; 2^30 is full scale.
    pub currents: [i32; 5],
    /// Velocity of the output shaft, 0.01 rad/s.
    pub velocity: i16,
}

impl Signals {
    fn value(&self, signal: Signal) -> i16 {
        let current = |index: usize| {
            self.currents
                .get(index)
                .map_or(0, |value| narrow(value >> 15))
        };
        let compare = |index: usize| match self.stage {
            PowerStage::Drive(values) => values
                .get(index)
                .map_or(0, |value| narrow(i32::from(*value))),
            PowerStage::Off | PowerStage::Brake => 0,
        };
        match signal {
            Signal::None => 0,
            Signal::CurrentA => current(0),
            Signal::CurrentB => current(1),
            Signal::CurrentD => current(2),
            Signal::CurrentQ => current(3),
            Signal::Demand => current(4),
            Signal::CompareA => compare(0),
            Signal::CompareB => compare(1),
            Signal::CompareC => compare(2),
            Signal::Rotor => self.readings.rotor as i16,
            Signal::Velocity => self.velocity,
        }
    }
}

/// Converts to 16 bits. Saturates.
fn narrow(value: i32) -> i16 {
    if value > i32::from(i16::MAX) {
        i16::MAX
    } else if value < i32::from(i16::MIN) {
        i16::MIN
    } else {
        value as i16
    }
}

/// State of a recording (object 0x2061).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum State {
    /// Nothing is recorded.
    Idle = 0,
    /// Records into the ring until a fault comes.
    Armed = 1,
    /// Records the rest.
    Recording = 2,
    /// All samples are there.
    Done = 3,
}

/// What a client asks for (object 0x2060).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Request {
    /// 1 records at once, 2 arms the recording for a fault; another value ends it.
    pub command: u8,
    /// Codes of the four [`Signal`]s; the first one in the low byte.
    pub signals: u32,
    /// PWM periods per sample; 0 counts as 1.
    pub decimation: u16,
    /// Samples before the fault, at most 511.
    pub pre_trigger: u16,
}

/// A recording.
#[derive(Clone, Debug)]
pub struct Capture {
    samples: [Sample; SAMPLES],
    signals: [Signal; CHANNELS],
    state: State,
    /// PWM periods between two samples.
    skipped: u16,
    /// PWM periods until the next sample.
    wait: u16,
    /// Place of the next sample, and samples that are stored.
    next: u16,
    stored: u16,
    /// Samples that are still to be recorded after the trigger.
    left: u16,
    pre_trigger: u16,
    /// Samples before the trigger.
    before: u16,
}

impl Capture {
    /// Creates an empty recording. It is all zeros, so that a static one takes no program memory.
    pub const fn new() -> Self {
        Self {
            samples: [[0; CHANNELS]; SAMPLES],
            signals: [Signal::None; CHANNELS],
            state: State::Idle,
            skipped: 0,
            wait: 0,
            next: 0,
            stored: 0,
            left: 0,
            pre_trigger: 0,
            before: 0,
        }
    }

    /// Follows a client's request. The samples of the recording before are lost.
    pub fn request(&mut self, request: Request) {
        self.signals = request.signals.to_le_bytes().map(Signal::from_code);
        self.skipped = request.decimation.saturating_sub(1);
        self.pre_trigger = if usize::from(request.pre_trigger) < SAMPLES {
            request.pre_trigger
        } else {
            SAMPLES as u16 - 1
        };
        (self.wait, self.next, self.stored, self.before) = (0, 0, 0, 0);
        self.left = SAMPLES as u16;
        self.state = match request.command {
            1 => State::Recording,
            2 => State::Armed,
            _ => State::Idle,
        };
    }

    /// Triggers an armed recording: a fault was raised.
    pub fn fault(&mut self) {
        if self.state != State::Armed {
            return;
        }
        self.before = if self.stored < self.pre_trigger {
            self.stored
        } else {
            self.pre_trigger
        };
        self.left = SAMPLES as u16 - self.before;
        self.state = State::Recording;
    }

    /// Returns whether the PWM interrupt must call [`Capture::record`].
    pub fn is_active(&self) -> bool {
        matches!(self.state, State::Armed | State::Recording)
    }

    /// Records one PWM period, if a sample is due.
    pub fn record(&mut self, signals: &Signals) {
        if self.wait > 0 {
            self.wait -= 1;
            return;
        }
        self.wait = self.skipped;
        if !self.is_active() {
            return;
        }
        if let Some(sample) = self.samples.get_mut(usize::from(self.next)) {
            *sample = self.signals.map(|signal| signals.value(signal));
        }
        self.next = (self.next + 1) % SAMPLES as u16;
        if usize::from(self.stored) < SAMPLES {
            self.stored += 1;
        }
        if self.state == State::Recording {
            self.left -= 1;
            if self.left == 0 {
                self.state = State::Done;
            }
        }
    }

    /// Returns the state of the recording.
    pub fn state(&self) -> State {
        self.state
    }

    /// Returns the number of samples before the fault.
    pub fn before(&self) -> u16 {
        self.before
    }

    /// Returns 64 samples in the order of their time, from sample `64 * window` of 512; zeros
    /// beyond.
    pub fn window(&self, window: u16) -> [Sample; WINDOW] {
        let first = usize::from(window) * WINDOW;
        // With fewer samples than the ring holds, the oldest is the first.
        let oldest = if usize::from(self.stored) < SAMPLES {
            0
        } else {
            usize::from(self.next)
        };
        core::array::from_fn(|index| {
            let index = first + index;
            let place = (oldest + index) % SAMPLES;
            let sample = self.samples.get(place).filter(|_| index < SAMPLES);
            sample.copied().unwrap_or_default()
        })
    }
}

impl Default for Capture {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The signals of PWM period `period`: a rotor that turns one count in each period.
    fn signals(period: u32) -> Signals {
        Signals {
            readings: Readings {
                currents: [0; 2],
                rotor: period,
                ..Readings::default()
            },
            stage: PowerStage::Drive([7, 8, 60_000]),
            currents: [1 << 30, -(1 << 29), 3 << 15, 4 << 15, i32::MIN],
            velocity: -5,
        }
    }

    fn run(capture: &mut Capture, periods: core::ops::Range<u32>) {
        for period in periods {
            if capture.is_active() {
                capture.record(&signals(period));
            }
        }
    }

    fn all(capture: &Capture, channel: usize) -> impl Iterator<Item = i16> {
        (0..8).flat_map(move |window| capture.window(window).map(|sample| sample[channel]))
    }

    fn request(command: u8, decimation: u16, pre_trigger: u16) -> Request {
        Request {
            command,
            signals: 9,
            decimation,
            pre_trigger,
        }
    }

    #[test]
    fn a_recording_holds_every_sample_in_order() {
        for decimation in [1, 3, 40] {
            let mut capture = Capture::new();
            capture.request(request(1, decimation, 100));
            run(&mut capture, 0..512 * u32::from(decimation));
            assert_eq!((capture.state(), capture.before()), (State::Done, 0));
            let expected = (0..512).map(|index| index * decimation as i16);
            assert!(all(&capture, 0).eq(expected), "{decimation}");
        }
    }

    #[test]
    fn a_fault_leaves_the_samples_before_it() {
        // Periods until the fault, wanted samples before it, and samples that there are.
        for (fault, wanted, there) in [(2_000, 100, 100), (50, 100, 50), (700, 9_999, 511)] {
            let mut capture = Capture::new();
            capture.request(request(2, 1, wanted));
            run(&mut capture, 0..fault);
            assert_eq!(capture.state(), State::Armed);
            capture.fault();
            run(&mut capture, fault..fault + 1_000);
            assert_eq!((capture.state(), capture.before()), (State::Done, there));
            let first = fault as i16 - there as i16;
            assert!(all(&capture, 0).eq(first..first + 512), "{fault}");
            capture.fault();
            assert_eq!(capture.state(), State::Done);
        }
    }

    #[test]
    fn every_signal_is_scaled_and_saturates() {
        let expected = [0, 32_767, -16_384, 3, 4, -32_768, 7, 8, 32_767, 77, -5, 0];
        for (code, expected) in expected.into_iter().enumerate() {
            let value = signals(77).value(Signal::from_code(code as u8));
            assert_eq!(value, expected, "{code}");
        }
    }
}
