//! What is in a letter: a head as JSON, and arrays as they are in memory.
//!
//! ```text
//! u64 length, head, { u64 length, array }…        lengths in bytes, little-endian
//! ```

use crate::{Error, Result};
use bytemuck::{AnyBitPattern, NoUninit};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A letter that is written.
pub struct Packet(Vec<u8>);

impl Packet {
    /// One with this head, and no arrays yet.
    pub fn of(head: &impl Serialize) -> Self {
        // Types that JSON cannot hold (maps by other things than strings) would give a letter that nobody can read.
        Self(Vec::new()).with(&serde_json::to_vec(head).unwrap_or_default())
    }

    /// The same with one more array.
    #[must_use]
    pub fn with<T: NoUninit>(mut self, values: &[T]) -> Self {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.0.reserve(bytes.len() + 8);
        self.0.extend((bytes.len() as u64).to_le_bytes());
        self.0.extend(bytes);
        self
    }

    /// The bytes that are sent.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// A letter that is read, part by part.
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// From its beginning.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Its head.
    ///
    /// # Errors
    /// [`Error::Failed`] when it is none of this type.
    pub fn head<T: DeserializeOwned>(&mut self) -> Result<T> {
        serde_json::from_slice(self.part()?)
            .map_err(|error| Error::Failed(format!("a letter of another process makes no sense: {error}")))
    }

    /// The next array.
    ///
    /// # Errors
    /// [`Error::Failed`] when there is none, or it does not consist of whole elements.
    pub fn array<T: AnyBitPattern + NoUninit>(&mut self) -> Result<Vec<T>> {
        let part = self.part()?;
        if !part.len().is_multiple_of(size_of::<T>().max(1)) {
            return Err(broken());
        }
        Ok(bytemuck::pod_collect_to_vec(part))
    }

    fn part(&mut self) -> Result<&'a [u8]> {
        let (length, rest) = self.0.split_first_chunk::<8>().ok_or_else(broken)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| broken())?;
        let (part, rest) = rest.split_at_checked(length).ok_or_else(broken)?;
        self.0 = rest;
        Ok(part)
    }
}

fn broken() -> Error {
    Error::Failed("a letter of another process is not whole".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out() {
        let bytes =
            Packet::of(&("head", 7)).with(&[1.5_f32, -2.5]).with::<u64>(&[]).with(&[9_u64]).into_bytes();
        let mut reader = Reader::new(&bytes);
        assert_eq!(reader.head::<(String, u32)>().unwrap(), ("head".to_owned(), 7));
        assert_eq!(reader.array::<f32>().unwrap(), [1.5, -2.5]);
        assert!(reader.array::<u64>().unwrap().is_empty());
        assert_eq!(reader.array::<u64>().unwrap(), [9]);
        assert!(reader.array::<u64>().is_err());
    }

    #[test]
    fn letters_that_are_cut_or_of_another_kind_are_refused() {
        let whole = Packet::of(&7_u32).with(&[1_u32, 2, 3]).into_bytes();
        let read = |bytes: &[u8]| {
            let mut reader = Reader::new(bytes);
            reader.head::<u32>().and_then(|_| reader.array::<u32>())
        };
        assert_eq!(read(&whole).unwrap(), [1, 2, 3]);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
        let mut huge = whole.clone();
        huge[..8].fill(0xff);
        assert!(read(&huge).is_err());
        assert!(Reader::new(&whole).head::<String>().is_err());
        assert!(Reader::new(&Packet::of(&1).with(&[1_u8; 7]).into_bytes()).array::<u32>().is_err());
    }
}
