// The parameters of a phase function (see common/phase.cl); a build reads those that it needs.
struct Phase {
    float g0;     // mean cosine of the first lobe, |g| <= 0.999
    float g1;     // ... and of the second one
    float weight; // share of the first lobe, 0 to 1
    float pad;
};
