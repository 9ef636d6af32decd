//! The order of keys, and which of the sorted lie in each cell.

/// The numbers of the keys in ascending order of keys; equal ones stay in their order.
pub fn order<K: Ord>(keys: &[K]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|&i| &keys[i as usize]);
    order
}

/// Per cell: the place of its first key, and one past that of its last; both 0 for empty cells.
pub fn cell_ranges(sorted: &[u32], cells: usize) -> Vec<[u32; 2]> {
    let range = |cell: u32| {
        let [first, end] = [cell, cell + 1].map(|key| sorted.partition_point(|&k| k < key) as u32);
        if first < end { [first, end] } else { [0, 0] }
    };
    (0..cells as u32).map(range).collect()
}
