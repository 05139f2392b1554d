//! Memory that two threads share without locks: slots of numbers that are atomic one by one.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Value that is kept as so many numbers.
pub(super) trait Packed<const N: usize> {
    fn pack(&self) -> [u64; N];
    fn unpack(numbers: &[u64; N]) -> Self;
}

/// Slots by number, which go round. A counter that is published afterwards orders the writes.
#[derive(Debug)]
pub(super) struct Slots<const N: usize>(Box<[[AtomicU64; N]]>);

impl<const N: usize> Slots<N> {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count.max(1)).map(|_| [const { AtomicU64::new(0) }; N]).collect())
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn store(&self, number: usize, value: &impl Packed<N>) {
        if let Some(slot) = self.0.get(number % self.0.len().max(1)) {
            slot.iter().zip(value.pack()).for_each(|(at, bits)| at.store(bits, Ordering::Relaxed));
        }
    }

    pub(super) fn load<T: Packed<N>>(&self, number: usize) -> Option<T> {
        let slot = self.0.get(number % self.0.len().max(1))?;
        Some(T::unpack(&slot.each_ref().map(|at| at.load(Ordering::Relaxed))))
    }
}

/// Queue of a fixed size from one thread to one other.
#[derive(Debug)]
pub(super) struct NumberQueue<const N: usize> {
    slots: Slots<N>,
    /// Values sent and taken since the start; each is written by one thread.
    sent: AtomicUsize,
    taken: AtomicUsize,
}

impl<const N: usize> NumberQueue<N> {
    pub(super) fn new(count: usize) -> Self {
        let (sent, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
        Self { slots: Slots::new(count), sent, taken }
    }

    /// Sends a value; `None` where the queue is full.
    pub(super) fn send(&self, value: &impl Packed<N>) -> Option<()> {
        let sent = self.sent.load(Ordering::Relaxed);
        let used = sent.wrapping_sub(self.taken.load(Ordering::Acquire));
        (used < self.slots.len()).then_some(())?;
        self.slots.store(sent, value);
        self.sent.store(sent.wrapping_add(1), Ordering::Release);
        Some(())
    }

    /// Takes the next value; `None` where none waits.
    pub(super) fn take<T: Packed<N>>(&self) -> Option<T> {
        let taken = self.taken.load(Ordering::Relaxed);
        (self.sent.load(Ordering::Acquire) != taken).then_some(())?;
        let value = self.slots.load(taken)?;
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(value)
    }
}

/// A real number that one thread writes and others read.
#[derive(Debug)]
pub(super) struct AtomicReal(AtomicU64);

impl AtomicReal {
    pub(super) fn new(value: f64) -> Self {
        Self(AtomicU64::new(value.to_bits()))
    }

    pub(super) fn set(&self, value: f64) {
        self.0.store(value.to_bits(), Ordering::Release);
    }

    pub(super) fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Acquire))
    }
}
