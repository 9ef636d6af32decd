// A photon where it met a diffuse surface, in local units.
struct Photon {
    float4 position; // w, as bits: the direction of travel (see pack_direction)
    float4 flux;     // per channel, over the square of the local unit; w, as bits: the surface + 1, 0: nothing is stored
};
