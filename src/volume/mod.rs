//! Volumes on the host: readers for files, procedural fields, brick ranges.
