//! Arbitrary and damaged bytes: whatever a file holds, no reader panics.

use crate::corpus::*;
use proptest::prelude::*;
use std::fs;
use svetlo::volume::StoredType;
use tempfile::TempDir;

/// Beginnings that lead a reader past its first checks.
const BEGINNINGS: [&str; 6] = [
    "",
    "NRRD0004\n",
    "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ",
    "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n",
    "ObjectType = Image\nNDims = 3\n",
    "\u{1f}\u{8b}\u{8}",
];

const NAMES: [&str; 10] = [
    "a.nrrd",
    "a.nhdr",
    "a.nii",
    "a.nii.gz",
    "a.hdr",
    "a.mha",
    "a.mhd",
    "a_2x2x2_uint8.raw",
    "a_2x2x2_uint8.raw.gz",
    "a.bin",
];

proptest! {
    #[test]
    fn random_bytes_never_panic(
        name in 0..NAMES.len(), beginning in 0..BEGINNINGS.len(), tail in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join(NAMES[name]);
        let start: Vec<u8> = BEGINNINGS[beginning].chars().map(|c| c as u8).collect();
        fs::write(&path, join(&[&start, &tail])).unwrap();
        let _ = read_plainly(&path);
    }

    #[test]
    fn random_header_lines_never_panic(
        meta in any::<bool>(),
        lines in prop::collection::vec(
            ("(type|dimension|sizes|encoding|endian|spacings|space directions|byte skip|line skip|data file|NDims|\
               DimSize|ElementType|ElementSpacing|HeaderSize|CompressedData|BinaryData|ElementDataFile)",
             "(uint8|double|3|4|-1|0|2 2 2|99999999999999999999 1 1|raw|gzip|ascii|nan 1 -1|\\(1,0,0\\) none|LOCAL|\
               MET_UCHAR|True|[ -~]{0,12})"), 0..14),
    ) {
        let folder = TempDir::new().unwrap();
        let (name, magic, between) = if meta { ("a.mha", "", " = ") } else { ("a.nrrd", "NRRD0004\n", ": ") };
        let body: Vec<String> = lines.iter().map(|(key, value)| format!("{key}{between}{value}\n")).collect();
        fs::write(folder.path().join(name), format!("{magic}{}\n12345678", body.concat())).unwrap();
        let _ = read_plainly(&folder.path().join(name));
    }

    #[test]
    fn flipped_bits_never_panic(
        kind in 0..6usize, which in 0..23usize, flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8u8), 1..4),
    ) {
        let (kind, endian) = (StoredType::ALL[kind], ENDIANS[which % 2]);
        let mut cases = nrrd_cases(kind, endian);
        cases.extend(nifti_cases(kind, endian));
        cases.extend(meta_cases(kind, endian));
        cases.extend(raw_cases(kind, endian));
        let mut case = cases[which].clone();
        for (place, bit) in flips {
            let at = place.index(case.bytes.len());
            case.bytes[at] ^= 1 << bit;
        }
        let folder = TempDir::new().unwrap();
        let _ = read_plainly(&case.write(folder.path()));
    }
}
