//! Which parts of a picture an image holds, as its header says it.

use super::share::Share;
use std::collections::BTreeMap;
use std::fmt;

/// What an image has of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// Samples that every pixel has.
    pub samples: u32,
    /// How many more some pixels have at most: the part was interrupted, or several devices were at it.
    pub more: u32,
}

/// Parts of one picture that an image holds: one as rendered, or several merged.
///
/// In the header a part as rendered is `2/8`, merged ones are `1,2,5/8: 16,16,12+`: parts, of how many, and the samples
/// of each, with `+` where some pixels have one more, `+3` where some have up to three more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parts {
    of: u32,
    held: BTreeMap<u32, Held>,
}

impl Parts {
    /// A single part.
    pub fn one(share: Share, held: Held) -> Self {
        Self { of: share.of(), held: [(share.number(), held)].into() }
    }

    /// The parts in the header of an image; `samples`: what it says that each pixel has, at least.
    ///
    /// # Errors
    /// That the text is none of parts.
    pub fn read(text: &str, samples: u32) -> Result<Self, String> {
        Self::parse(text, samples)
            .ok_or_else(|| format!("svetlo.part in its header is `{text}`, not parts of a picture"))
    }

    fn parse(text: &str, samples: u32) -> Option<Self> {
        let Some((parts, counts)) = text.split_once(": ") else {
            return Some(Self::one(text.parse().ok()?, Held { samples, more: 0 }));
        };
        let (numbers, of) = parts.split_once('/')?;
        let mut held = BTreeMap::new();
        let mut counts = counts.split(',');
        for number in numbers.split(',') {
            let share: Share = format!("{number}/{of}").parse().ok()?;
            let count = counts.next()?;
            let (whole, more) = match count.split_once('+') {
                None => (count, 0),
                Some((whole, "")) => (whole, 1),
                Some((whole, more)) => (whole, more.parse().ok()?),
            };
            let one = Held { samples: whole.parse().ok()?, more };
            if held.insert(share.number(), one).is_some() {
                return None;
            }
        }
        let all = Self { of: of.parse().ok()?, held };
        (counts.next().is_none() && all.samples() == u64::from(samples)).then_some(all)
    }

    /// Says how many samples more some pixels have of a single part.
    pub(super) fn set_more(&mut self, more: u32) {
        self.held.values_mut().for_each(|held| held.more = more);
    }

    /// The part, if it is a single one as rendered or merged alone.
    pub fn single(&self) -> Option<Share> {
        let mut numbers = self.held.keys();
        let first = *numbers.next()?;
        if numbers.next().is_some() { None } else { Share::new(first, self.of) }
    }

    /// Of how many parts these are.
    pub fn of(&self) -> u32 {
        self.of
    }

    /// The parts and what there is of each, in their order.
    pub fn held(&self) -> impl ExactSizeIterator<Item = (u32, Held)> {
        self.held.iter().map(|(&number, &held)| (number, held))
    }

    /// The number of the first part.
    pub fn first(&self) -> u32 {
        self.held.keys().next().copied().unwrap_or(0)
    }

    /// Samples that every pixel has of all parts.
    pub fn samples(&self) -> u64 {
        self.held.values().map(|held| u64::from(held.samples)).sum()
    }

    /// The most samples that a pixel may have.
    pub fn most_samples(&self) -> u64 {
        self.held.values().map(|held| u64::from(held.samples) + u64::from(held.more)).sum()
    }

    /// The parts that are not there.
    pub fn missing(&self) -> Vec<u32> {
        (1..=self.of).filter(|number| !self.held.contains_key(number)).collect()
    }

    /// A part that is in both.
    pub fn common(&self, other: &Self) -> Option<u32> {
        self.held.keys().find(|number| other.held.contains_key(number)).copied()
    }

    /// Whether both are the same parts, with however many samples.
    pub(super) fn are_those_of(&self, other: &Self) -> bool {
        self.of == other.of && self.held.keys().eq(other.held.keys())
    }

    /// Both together; they are of as many parts, and have none in common.
    pub fn add(&mut self, other: &Self) {
        self.held.extend(&other.held);
    }

    /// Whether these are all samples from the first to some last one, of every pixel: then the picture can be continued.
    pub fn is_whole(&self) -> bool {
        let samples = self.samples();
        self.held.len() == self.of as usize
            && self.held().all(|(number, held)| {
                held.more == 0
                    && Share::new(number, self.of).is_some_and(|share| share.count(samples) == held.samples)
            })
    }
}

impl fmt::Display for Parts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.held.keys().map(u32::to_string).collect();
        let count = |held: &Held| match held.more {
            0 => held.samples.to_string(),
            1 => format!("{}+", held.samples),
            more => format!("{}+{more}", held.samples),
        };
        let counts: Vec<String> = self.held.values().map(count).collect();
        write!(f, "{}/{}: {}", numbers.join(","), self.of, counts.join(","))
    }
}

/// Runs of numbers that a list in words has at most.
const RUNS: usize = 8;

/// Parts in words: `part 3`, `parts 1-4 and 7`, the first few of many.
pub fn in_words(numbers: &[u32]) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some(run) if run.1 + 1 == number => run.1 = number,
            _ => runs.push((number, number)),
        }
    }
    let shown: u32 = runs.iter().take(RUNS).map(|(from, to)| to - from + 1).sum();
    let mut texts: Vec<String> = runs.iter().take(RUNS).map(|&(from, to)| run_in_words(from, to)).collect();
    let left = numbers.len() - shown as usize;
    if left > 0 {
        texts.push(format!("{left} more"));
    }
    let last = texts.pop().unwrap_or_default();
    let word = if numbers.len() == 1 { "part" } else { "parts" };
    if texts.is_empty() {
        format!("{word} {last}")
    } else {
        format!("{word} {} and {last}", texts.join(", "))
    }
}

fn run_in_words(from: u32, to: u32) -> String {
    match to - from {
        0 => from.to_string(),
        1 => format!("{from}, {to}"),
        _ => format!("{from}-{to}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, samples: u32) -> Parts {
        Parts::read(text, samples).unwrap()
    }

    #[test]
    fn headers_come_back_as_they_were() {
        for (text, samples) in
            [("1,3/4: 16,12+", 28), ("2/4: 5", 5), ("1,2/2: 0+,0", 0), ("1,2/2: 9+7,8", 17)]
        {
            assert_eq!(read(text, samples).to_string(), text);
        }
        let one = read("3/4", 7);
        assert_eq!((one.single(), one.samples()), (Share::new(3, 4), 7));
        assert_eq!(one.to_string(), "3/4: 7");
        for text in [
            "",
            "5/4",
            "1,1/4: 8,8",
            "1,2/4: 16",
            "1/4: 8,8",
            "1,2/4: 8,a",
            "2",
            "1,2/4: 8,7",
            "1,2/4: 8+8",
            "1,2/4: 8+a,8",
            "1,2/4: 8++,8",
            "1,/4: 8,8",
        ] {
            let refused = Parts::read(text, 16).unwrap_err();
            assert!(refused.contains(&format!("`{text}`, not parts of a picture")), "{refused}");
        }
    }

    #[test]
    fn all_samples_from_the_first_are_a_whole() {
        assert!(read("1,2,3/3: 3,3,2", 8).is_whole());
        assert!(read("1/1: 5", 5).is_whole());
        for (text, samples) in
            [("1,2,3/3: 3,2,3", 8), ("1,2,3/3: 3,3,2+", 8), ("1,2/3: 3,3", 6), ("1,2/2: 4,1", 5)]
        {
            assert!(!read(text, samples).is_whole(), "{text}");
        }
    }

    #[test]
    fn parts_add_up() {
        let mut all = read("1,3/4: 16,12+", 28);
        let other = read("4/4", 2);
        assert_eq!((all.common(&other), other.common(&all)), (None, None));
        all.add(&other);
        assert_eq!(all.to_string(), "1,3,4/4: 16,12+,2");
        assert_eq!((all.samples(), all.most_samples(), all.first()), (30, 31, 1));
        assert_eq!(read("1,2/2: 9+7,8+", 17).most_samples(), 25);
        assert_eq!((all.missing(), all.common(&read("2,3/4: 1,1", 2))), (vec![2], Some(3)));
    }

    #[test]
    fn lists_in_words() {
        for (numbers, text) in [
            (vec![3], "part 3"),
            (vec![1, 2], "parts 1, 2"),
            (vec![1, 2, 3, 7], "parts 1-3 and 7"),
            (vec![1, 3, 5, 6], "parts 1, 3 and 5, 6"),
            ((1..40).map(|k| 2 * k).collect(), "parts 2, 4, 6, 8, 10, 12, 14, 16 and 31 more"),
        ] {
            assert_eq!(in_words(&numbers), text);
        }
    }
}
