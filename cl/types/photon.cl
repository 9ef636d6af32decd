// A photon where it met a diffuse surface, in local units.
struct Photon {
    float4 position; // w, as bits: the direction of travel (see pack_direction)
    float4 flux;     // per channel, over the square of the local unit; w, as bits: the surface + 1, 0: nothing is stored
};

// Where the flux of some photons went: the mean over channels, over the square of the local unit. Photons that diffuse
// surfaces reflect have accounts of their own, where what is stored is no end of a photon and stands beside the others.
struct PhotonAccount {
    float4 met;       // emitted, stored, met diffuse surfaces directly (reflected ones: is of another role), absorbed
    float4 met_low;   // what `met` cannot hold
    float4 lost;      // escaped, cut by the limit on depth, and by that on bounces
    float4 lost_low;
    uint photons;
    uint stored;
    uint pad_0;
    uint pad_1;
};
