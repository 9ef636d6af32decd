// Path tracing in volumes: parameters, and what it counts.
struct Scattering {
    float4 low;              // low corner of what can hold extinction, grid coordinates
    float4 high;             // high corner
    float4 control;          // radiance that light is counted from
    float4 albedo;           // constant single-scattering albedo (CONSTANT_ALBEDO)
    float4 phase;            // mean cosines of the lobes, share of the first one
    float4 extinction;       // extinction per channel relative to sigma_t (CHROMATIC), largest 1
    float majorant_scale;    // factor of the majorants, >= 1
    float camera_threshold;  // above this transmittance a tentative collision of a camera ray scatters a part of it,
    float shadow_threshold;  // below, all or nothing: the same for shadow rays
    float flight_threshold;  // ... and for rays between collisions
    float split;             // a path scatters into the volume with probability split * (1 - transmittance), at most 1
    float sigma;             // constant extinction per local unit (CONSTANT_SIGMA)
    float ramp_offset;       // extinction = offset + slope * value (SIGMA_RAMP)
    float ramp_slope;
    float roulette_start;    // throughput below which paths play Russian roulette
    int max_order;           // largest number of scatterings, 2^31 - 1 for no limit
    uint paths;              // paths per sample and pixel
    float mean_sigma;        // mean extinction of the box per local unit, roughly
    int flights;             // flights from each collision: 1 where paths go on from them, 0 where they would see nothing
    uint pad_0;
    uint pad_1;
    uint pad_2;
};

// What the paths of a tile did, summed over its pixels and samples. Energies are weights of paths that start with 1,
// the mean over channels: escaped + absorbed + cut = paths + roulette.
struct Ledger {
    float4 energy;          // escaped, absorbed, cut by the limit on scatterings, gained (net) by Russian roulette
    float4 energy_low;      // what `energy` cannot hold
    uint paths_low;
    uint paths_high;
    uint lookups_low;       // tentative collisions: cells fetched
    uint lookups_high;
    uint collisions_low;    // those that scattered or absorbed (by any weight, where weights are fractions)
    uint collisions_high;
    uint above_low;         // those with extinction above the majorant: must stay 0
    uint above_high;
    uint unfinished;        // paths that the device did not follow to their end: must stay 0
    uint pad_0;
    uint pad_1;
    uint pad_2;
};

// Auxiliary images of a pixel: what camera rays meet first, as means over paths (and sums while a sample runs).
// Values times `taken` are those of the whole ray: outside the medium they are 0.
struct Auxiliary {
    float4 albedo;          // of the first collision, times the share of the ray that collides, per channel
    float4 normal;          // unit, towards lower values, or 0 where the field is flat; times `taken`
    float transmittance;    // of the camera ray
    float taken;            // the share that collides
    float depth;            // distance of the first collision from the eye, local units, times `taken`
    uint pad_0;
};
