// The accounts of what paths did.
#include "common/numeric.cl"
#include "render/paths.cl"

INLINE struct Tally empty_tally(void) {
    struct Tally tally;
    tally.escaped = tally.absorbed = tally.cut = tally.gained = (Reals)(0.0f);
    tally.lookups = tally.collisions = tally.above = 0u;
    return tally;
}

INLINE void count_up(__global uint *low, __global uint *high, uint more) {
    uint sum = *low + more;
    *high += sum < more;
    *low = sum;
}

// Adds a sample's tally to the ledger.
INLINE void settle_accounts(__global struct Ledger *ledger, const struct Tally *tally, uint paths, bool unfinished) {
    float4 energy = ledger->energy;
    float4 low = ledger->energy_low;
    two_float_add(&energy, &low, (float4)(sum_lanes(tally->escaped), sum_lanes(tally->absorbed), sum_lanes(tally->cut),
        sum_lanes(tally->gained)));
    ledger->energy = energy;
    ledger->energy_low = low;
    count_up(&ledger->paths_low, &ledger->paths_high, paths);
    count_up(&ledger->lookups_low, &ledger->lookups_high, tally->lookups);
    count_up(&ledger->collisions_low, &ledger->collisions_high, tally->collisions);
    count_up(&ledger->above_low, &ledger->above_high, tally->above);
    ledger->unfinished += unfinished;
}
