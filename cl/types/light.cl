// A light for surface shading.
struct Light {
    float4 position; // point: position in local units, w = 1; directional: unit direction of travel, w = 0;
                     // headlight: w = 2 (shines along the view ray)
    float4 power;    // point: intensity in W/sr over local units squared; otherwise irradiance
};
