//! Whole samples: who renders which, and in which order they are added.

use crate::caustics::PassLedger;
use crate::film::FilmPixel;
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;

/// A pixel of one sample, in a third of the memory.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Thin {
    mean: [f32; 4],
    depth: f32,
    lookups: [u32; 2],
    /// Of the counts, 1 bit each: samples added, samples with a depth.
    counts: u32,
}

/// A film of one sample, and where its photons went.
pub(super) struct Sample {
    pub pixels: Vec<Thin>,
    pub photons: PassLedger,
}

impl Sample {
    pub fn new(film: &[FilmPixel], photons: PassLedger) -> Self {
        let thin = |pixel: &FilmPixel| Thin {
            mean: pixel.mean,
            depth: pixel.depth,
            lookups: [pixel.lookups_low, pixel.lookups_high],
            counts: u32::from(pixel.count > 0) | u32::from(pixel.hits > 0) << 1,
        };
        Self { pixels: film.iter().map(thin).collect(), photons }
    }

    /// The film that it was made from.
    pub fn film(&self) -> Vec<FilmPixel> {
        let pixel = |thin: &Thin| FilmPixel {
            mean: thin.mean,
            depth: thin.depth,
            lookups_low: thin.lookups[0],
            lookups_high: thin.lookups[1],
            count: thin.counts & 1,
            hits: thin.counts >> 1,
            rejected: u32::from(thin.counts & 1 == 0),
            ..FilmPixel::zeroed()
        };
        self.pixels.iter().map(pixel).collect()
    }
}

/// The samples of a render, in order.
pub(super) struct Queue {
    /// The next one to be added.
    next: u32,
    /// Those on devices, and on how many.
    in_hand: BTreeMap<u32, Vec<usize>>,
    /// Those that wait to be added.
    waiting: BTreeMap<u32, Sample>,
    /// Whether somebody adds some.
    adding: bool,
}

impl Queue {
    pub fn new(next: u32) -> Self {
        Self { next, in_hand: BTreeMap::new(), waiting: BTreeMap::new(), adding: false }
    }

    /// Samples that have been added.
    pub fn added(&self) -> u32 {
        self.next
    }

    /// The next sample for `member`, of those below `goal`: the first that nobody has, or, where too many would wait for
    /// one that a slower device has in hand, that one again.
    pub fn take(&mut self, member: usize, members: usize, goal: u32) -> Option<u32> {
        let window = self.next.saturating_add(2 * members as u32).min(goal);
        let begun = self.next + u32::from(self.adding);
        let open = |sample: &u32| *sample >= begun && !self.waiting.contains_key(sample);
        let fresh = (self.next..window).find(|sample| open(sample) && !self.in_hand.contains_key(sample));
        let again = || {
            let mut others = self.in_hand.iter().filter(|(sample, _)| open(sample) && **sample < goal);
            others.find(|(_, who)| who.len() == 1 && !who.contains(&member)).map(|(sample, _)| *sample)
        };
        let sample = fresh.or_else(again)?;
        self.in_hand.entry(sample).or_default().push(member);
        Some(sample)
    }

    /// A member is done with a sample, or does not go on with it.
    pub fn release(&mut self, sample: u32, member: usize) {
        if let Some(who) = self.in_hand.get_mut(&sample) {
            who.retain(|&other| other != member);
            if who.is_empty() {
                self.in_hand.remove(&sample);
            }
        }
    }

    /// Keeps a sample until its turn; `false` when it has been rendered by another before.
    pub fn deliver(&mut self, number: u32, sample: Sample) -> bool {
        let fresh = number >= self.next + u32::from(self.adding) && !self.waiting.contains_key(&number);
        if fresh {
            self.waiting.insert(number, sample);
        }
        fresh
    }

    /// Whether a sample has come in whose turn it is and that nobody adds: who was to do so may have failed.
    pub fn has_next(&self) -> bool {
        !self.adding && self.waiting.contains_key(&self.next)
    }

    /// The sample whose turn it is, if nobody adds one now; [`Queue::added_one`] or [`Queue::put_back`] must follow.
    pub fn begin_adding(&mut self) -> Option<Sample> {
        if self.adding {
            return None;
        }
        let sample = self.waiting.remove(&self.next)?;
        self.adding = true;
        Some(sample)
    }

    pub fn added_one(&mut self) {
        (self.next, self.adding) = (self.next + 1, false);
    }

    pub fn put_back(&mut self, sample: Sample) {
        self.waiting.insert(self.next, sample);
        self.adding = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Sample {
        Sample::new(&[], PassLedger::default())
    }

    #[test]
    fn samples_are_added_in_order() {
        let mut queue = Queue::new(5);
        assert_eq!([queue.take(0, 2, 7), queue.take(1, 2, 7)], [Some(5), Some(6)]);
        assert!(queue.deliver(6, sample()));
        queue.release(6, 1);
        assert!(queue.begin_adding().is_none());
        // The other's again, but not one's own, and not a third time.
        assert_eq!([queue.take(0, 2, 7), queue.take(1, 2, 7), queue.take(1, 2, 7)], [None, Some(5), None]);
        assert!(queue.deliver(5, sample()) && !queue.deliver(5, sample()));
        let first = queue.begin_adding().unwrap();
        assert!(queue.begin_adding().is_none());
        // It is being added: nobody needs it again.
        assert!(!queue.deliver(5, sample()));
        queue.release(5, 1);
        assert_eq!(queue.take(1, 2, 6), None);
        assert!(!queue.has_next());
        queue.put_back(first);
        assert!(queue.has_next());
        for added in [6, 7] {
            assert!(queue.begin_adding().is_some());
            queue.added_one();
            assert_eq!(queue.added(), added);
        }
        assert!(queue.begin_adding().is_none());
        assert!(!queue.deliver(5, sample()));
    }

    #[test]
    fn few_samples_wait() {
        let mut queue = Queue::new(0);
        assert_eq!(queue.take(1, 2, 100), Some(0));
        for number in 1..4 {
            assert_eq!(queue.take(0, 2, 100), Some(number));
            assert!(queue.deliver(number, sample()));
            queue.release(number, 0);
        }
        assert_eq!(queue.take(0, 2, 100), Some(0));
        queue.release(0, 1);
        assert_eq!(queue.take(1, 2, 100), Some(0));
    }

    #[test]
    fn a_film_of_one_sample_comes_back() {
        let lit = FilmPixel {
            mean: [1.5, 2.5, 3.5, 1.0],
            depth: 4.5,
            lookups_low: 7,
            lookups_high: 1,
            count: 1,
            hits: 1,
            ..FilmPixel::zeroed()
        };
        let empty = FilmPixel { count: 1, ..FilmPixel::zeroed() };
        let rejected = FilmPixel { rejected: 1, lookups_low: 3, ..FilmPixel::zeroed() };
        let film = [lit, empty, rejected];
        assert_eq!(Sample::new(&film, PassLedger::default()).film(), film);
    }
}
