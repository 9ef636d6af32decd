// A light, for the shading of surfaces and of volumes. Lengths in local units.
#define LIGHT_DIRECTIONAL 0
#define LIGHT_POINT 1
#define LIGHT_HEADLIGHT 2
#define LIGHT_RECTANGLE 3

struct Light {
    float4 position; // point, rectangle (its centre): position; directional: unit direction of travel;
                     // w: which kind of light. A headlight shines along the view ray
    float4 power;    // point: intensity in W/sr over local units squared; rectangle: radiance; otherwise irradiance;
                     // w: the probability with which light_sample picks this light
    float4 edge_u;   // rectangle: one whole edge; w, any light: the sum of the probabilities up to this light
    float4 edge_v;   // the other edge; w: area
    float4 normal;   // unit, of the side that shines; w = 0
};
