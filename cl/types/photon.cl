// The mark of photons on surfaces: MARK_SURFACE has the surface + 1, MARK_INSIDE is there if they came from behind it, and
// above MARK_NORMAL is the surface's normal on the side that they came from (see caustics/marks.cl).
#define MARK_SURFACE 0x3ffffu
#define MARK_INSIDE 0x40000u
#define MARK_NORMAL 19

// The mark of photons in the medium: no surface has this, which is a float like others (2).
#define IN_MEDIUM 0x40000000u

// A photon where it met a diffuse surface, or where the medium scattered it, in local units.
struct Photon {
    float4 position; // w, as bits: the direction of travel (see pack_direction)
    float4 flux;     // per channel, over the square of the local unit; w, as bits: the mark; 0: nothing is stored
};

// Where the flux of some photons went: the mean over channels, over the square of the local unit. Photons that diffuse
// surfaces reflect have accounts of their own, where what is stored is no end of a photon and stands beside the others.
struct PhotonAccount {
    float4 met;       // emitted, stored, met diffuse surfaces directly (reflected ones: is of another role), absorbed
    float4 met_low;   // what `met` cannot hold
    float4 lost;      // escaped, cut by the limit on depth, absorbed by the medium (reflected ones: cut by the limit on
                      // bounces); w: scattered by the medium, of what is stored
    float4 lost_low;
    uint photons;
    uint stored;
    uint pad_0;
    uint pad_1;
};
