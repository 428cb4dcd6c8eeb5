//! The board of a guard: the sensor chips on the robot's body, the task that reads them, and the
//! serial line.

use super::clock;
use crate::boards::lockstep::Bus;
use crate::sensors::{self, Address, Published, Rates};
use core::cell::RefCell;
use core::future::Future;
use core::pin::Pin;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::{Context, Waker};
use critical_section::Mutex;
use std::boxed::Box;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::task::Wake;
use std::vec::Vec;
use tautrack::link::BodyMeasurands;
use tautrack::link::chips::Chips;

/// Maximum number of bytes that wait on the serial line.
const SERIAL: usize = 256;

/// Board of a guard. Nobody reads the chips of a drive's.
pub(super) struct Body {
    chips: Rc<Mutex<RefCell<Chips>>>,
    task: Option<Pin<Box<dyn Future<Output = ()>>>>,
    woken: Arc<Woken>,
    waker: Waker,
    /// What the task tells.
    pub published: Rc<Published>,
    serial: VecDeque<u8>,
}

/// The task is to run.
struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Body {
    /// Switches the chips on. `seed` is that of the run.
    pub fn new(seed: u64) -> Self {
        let woken = Arc::new(Woken(AtomicBool::new(false)));
        Self {
            chips: Rc::new(Mutex::new(RefCell::new(Chips::new(seed)))),
            task: None,
            waker: Waker::from(Arc::clone(&woken)),
            woken,
            published: Rc::new(Published::new()),
            serial: VecDeque::new(),
        }
    }

    /// Starts the task that reads the chips.
    pub fn start(&mut self, rates: Rates) {
        let (bus, published) = (Bus(Rc::clone(&self.chips)), Rc::clone(&self.published));
        self.task = Some(Box::pin(async move {
            sensors::run(bus, Address::Low, rates, &published).await;
        }));
        self.woken.0.store(true, Ordering::Relaxed);
        self.poll();
    }

    /// Runs the chips for one step, and takes over the bytes of the serial line. Those that do not
    /// fit are lost.
    pub fn measure(&mut self, acts: Option<&BodyMeasurands>, serial: &[u8]) {
        if let Some(acts) = acts {
            critical_section::with(|cs| self.chips.borrow(cs).borrow_mut().measure(acts));
        }
        let room = SERIAL - self.serial.len();
        self.serial.extend(serial.iter().take(room));
    }

    /// Runs the task as far as it gets at this time.
    pub fn poll(&mut self) {
        if clock::expired() {
            self.woken.0.store(true, Ordering::Relaxed);
        }
        let Some(task) = &mut self.task else { return };
        while self.woken.0.swap(false, Ordering::Relaxed) {
            // The task never ends.
            let _ = task.as_mut().poll(&mut Context::from_waker(&self.waker));
        }
    }

    /// Takes bytes from the serial line, at most `count`.
    pub fn take_serial(&mut self, count: usize) -> Vec<u8> {
        self.serial.drain(..count.min(self.serial.len())).collect()
    }
}
