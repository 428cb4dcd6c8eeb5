//! Keeps a series of any length in bounded memory, without losing a peak.

/// Maximum number of intervals of one sample: the page of a run of up to a minute has all samples.
const MOST_SINGLE: usize = 6_000;
/// Maximum number of intervals of several samples, for which the page has three numbers instead of
/// one. A plot is narrower than half of this, in pixels.
const MOST: usize = 3_000;

/// An item that can be merged with the following one.
pub trait Merge {
    /// Merges the following item into this one.
    fn merge(&mut self, later: Self);
}

/// A series of intervals, each of the same number of samples. When there are too many intervals,
/// this number doubles: each interval is merged with the next one.
pub struct Decimated<T> {
    intervals: Vec<T>,
    /// Number of samples in an interval.
    length: usize,
    samples: usize,
}

impl<T> Default for Decimated<T> {
    fn default() -> Self {
        Self {
            intervals: Vec::new(),
            length: 1,
            samples: 0,
        }
    }
}

impl<T: Merge> Decimated<T> {
    /// Adds the next sample.
    pub fn add(&mut self, item: T) {
        if self.samples.is_multiple_of(self.length) {
            while self.intervals.len() == self.most() {
                self.halve();
            }
            self.intervals.push(item);
        } else if let Some(last) = self.intervals.last_mut() {
            last.merge(item);
        }
        self.samples += 1;
    }

    fn most(&self) -> usize {
        if self.length == 1 { MOST_SINGLE } else { MOST }
    }

    fn halve(&mut self) {
        let mut items = std::mem::take(&mut self.intervals).into_iter();
        while let Some(mut item) = items.next() {
            items.next().into_iter().for_each(|next| item.merge(next));
            self.intervals.push(item);
        }
        self.length *= 2;
    }

    /// The intervals in order. The last one may be incomplete.
    pub fn intervals(&self) -> &[T] {
        &self.intervals
    }

    /// Number of samples in an interval: a power of two.
    pub fn length(&self) -> usize {
        self.length
    }
}

/// Values of one curve in an interval.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The first value; NaN if the interval has no value.
    pub first: f64,
    /// Minimum of all values.
    pub least: f64,
    /// Maximum of all values.
    pub most: f64,
}

impl Span {
    /// An interval of one sample, whose value may be absent. A value that is not finite counts as
    /// absent.
    pub fn new(value: Option<f64>) -> Self {
        let value = value.filter(|value| value.is_finite()).unwrap_or(f64::NAN);
        Self {
            first: value,
            least: value,
            most: value,
        }
    }
}

impl Merge for Span {
    fn merge(&mut self, later: Self) {
        // A minimum or maximum ignores NaN.
        if self.first.is_nan() {
            self.first = later.first;
        }
        self.least = self.least.min(later.least);
        self.most = self.most.max(later.most);
    }
}

/// The curves of an interval. Later intervals may have more curves.
impl Merge for Vec<Span> {
    fn merge(&mut self, later: Self) {
        self.resize(self.len().max(later.len()), Span::new(None));
        for (span, later) in self.iter_mut().zip(later) {
            span.merge(later);
        }
    }
}
