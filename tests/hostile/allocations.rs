//! The largest single allocation and the most bytes held at once, of a piece of code.
#![allow(unsafe_code, dead_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static LARGEST: AtomicUsize = AtomicUsize::new(0);
static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn gained(bytes: usize) {
    LARGEST.fetch_max(bytes, Relaxed);
    MOST.fetch_max(HELD.fetch_add(bytes, Relaxed) + bytes, Relaxed);
}

// SAFETY: everything is the system allocator's, to which each call is handed on as it came; the counters change nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        gained(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        gained(layout.size());
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`, and `alloc` was the system's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// What [`measured`] found, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Allocated {
    /// The largest single allocation.
    pub largest: usize,
    /// The most held at once beyond what was held before.
    pub most: usize,
}

/// Runs a piece of code, alone among those that are measured, and says what it allocated: with what other threads do
/// meanwhile, so whoever allocates much does it in here.
pub fn measured<T>(body: impl FnOnce() -> T) -> (T, Allocated) {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let before = HELD.load(Relaxed);
    LARGEST.store(0, Relaxed);
    MOST.store(before, Relaxed);
    let result = body();
    let most = MOST.load(Relaxed).saturating_sub(before);
    (result, Allocated { largest: LARGEST.load(Relaxed), most })
}
