//! Why a node does not start.

use core::fmt::Display;

/// Text that tells a person why a node refuses its settings.
#[cfg(any(not(target_os = "none"), feature = "mps2"))]
pub type Refusal = heapless::String<160>;

/// What of a node refuses its settings. A board without the simulator's link has no more text.
#[cfg(not(any(not(target_os = "none"), feature = "mps2")))]
pub type Refusal = &'static str;

/// Returns the text of a refusal.
pub fn text(refusal: &Refusal) -> &str {
    refusal
}

/// Makes a [`Refusal`] of `what` is refused and the reason `why`; cuts off what exceeds its
/// capacity. A board without the simulator's link has nobody to read the text, so its program
/// contains no code that formats the reason.
#[cfg(any(not(target_os = "none"), feature = "mps2"))]
pub fn refuse(what: &'static str, why: impl Display) -> Refusal {
    use core::fmt::Write;
    struct Cut(Refusal);
    impl Write for Cut {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            text.chars()
                .try_for_each(|letter| self.0.push(letter).map_err(|_| core::fmt::Error))
        }
    }
    let mut text = Cut(Refusal::new());
    let _ = write!(text, "{what}: {why}"); // the only error is a full text
    text.0
}

/// Makes a [`Refusal`] of `what` is refused, without the reason.
#[cfg(not(any(not(target_os = "none"), feature = "mps2")))]
pub fn refuse(what: &'static str, _: impl Display) -> Refusal {
    what
}
