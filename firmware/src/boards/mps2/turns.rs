//! Several nodes on one emulated machine, which take turns.
//!
//! Emulators beside each other displace each other's translated code from the processor's caches,
//! and then take more than twice the time. Nodes on one machine share the translated code. They run
//! the same program and are idle between two messages, so a node is what its static variables hold.
//!
//! Some of these variables are exchanged only for a node that needs them: the largest ones, in the
//! section `.seldom`, and those that only a guard or only a screw uses.

use super::semihosting::Stream;
use crate::boards::lockstep::{Kept, kept};
use crate::roles::Role;
use core::slice;

/// Maximum number of nodes in the life of a machine.
const NODES: usize = 1 + u8::MAX as usize;

unsafe extern "C" {
    /// First address of the static variables, and ends from the link script: of those in `.seldom`,
    /// of those that only a guard uses, of those that only a screw uses, and of all.
    static mut __sdata: u8;
    static mut __eseldom: u8;
    static mut __eguard: u8;
    static mut __escrew: u8;
    static mut __ebss: u8;
}

/// Static variables of the nodes whose turn it is not.
pub struct Turns {
    file: Stream,
    /// Node to which the variables in memory belong. [`NODES`] stands for a node before its first
    /// message, which all nodes are equal to.
    current: usize,
    /// Number of nodes that have had a message.
    started: usize,
    /// Variables of each node that are in the file. The last node is that before its first message.
    kept: [Kept; NODES + 1],
}

impl Turns {
    /// No node has had a message. `None` if the host has no room for temporary files.
    pub fn new() -> Option<Self> {
        Some(Self {
            file: Stream::temporary()?,
            current: NODES,
            started: 0,
            kept: [Kept::All; NODES + 1],
        })
    }

    /// Exchanges the static variables, which belong to a node with `role`, for those of `node`.
    /// Numbers begin at 0 and leave none out. Returns `false` for other numbers, and if the file
    /// fails.
    ///
    /// # Safety
    /// No static variable is borrowed, except by references that the nodes have in common.
    pub unsafe fn turn_to(&mut self, node: u8, role: &Role) -> bool {
        let next = usize::from(node);
        if next == self.current {
            return true;
        }
        let from = if next < self.started { next } else { NODES };
        if next > self.started {
            return false;
        }
        let leaving = if self.current == NODES {
            Kept::All
        } else {
            kept(role)
        };
        self.kept[self.current] = leaving;
        let coming = self.kept[from];
        let start = &raw mut __sdata;
        let offset = |end: *mut u8| end as usize - start as usize;
        let length = offset(&raw mut __ebss);
        let begin = |kept| match kept {
            Kept::All => 0,
            Kept::Guard => offset(&raw mut __eseldom),
            Kept::Screw => offset(&raw mut __eguard),
            Kept::Axle => offset(&raw mut __escrew),
        };
        // SAFETY: the link script puts the static variables there, and by the contract of this
        // function nothing else refers to them.
        let variables = unsafe { slice::from_raw_parts_mut(start, length) };

        let place = begin(leaving);
        let mut exchanged = self.file.seek(self.current * length + place)
            && self.file.write_all(&variables[place..]);
        // `.seldom` holds what the leaving node needs; for the next it must be as at power-up. What
        // the other parts hold, nobody reads.
        if leaving == Kept::All && coming != Kept::All {
            let left = &mut variables[..begin(Kept::Guard)];
            exchanged &= self.file.seek(NODES * length) && self.file.read_exact(left);
        }
        let place = begin(coming);
        exchanged &=
            self.file.seek(from * length + place) && self.file.read_exact(&mut variables[place..]);
        self.current = next;
        self.started = self.started.max(next + 1);
        exchanged
    }
}
