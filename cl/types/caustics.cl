// Parameters of pictures of surfaces.
struct Caustics {
    float4 white;       // one over the mean colour of all wavelengths (DISPERSION)
    float photon_scale; // factor of what photons give; 0: there are none
    float split;        // rays that carry less than this part of the picture's light are reflected or refracted, not both
    uint plane_count;
    uint node_count;
    uint depth;         // most reflections and refractions
    uint pad_0;
    uint pad_1;
    uint pad_2;
};
