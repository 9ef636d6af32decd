// Photons that diffuse surfaces reflect: what they bring to the diffuse surfaces after the first.
//
// Light that is L S+ D or L D when it first meets a diffuse surface (Heckbert 1990) is photons.cl's, or direct light. What
// is on its way from there comes here, in two roles, so that every path belongs to one: that which met mirrors or glass
// first, sent to where they are, and that which met a diffuse surface first, sent everywhere. A photon's slot holds one of
// its places: each with the same chance, for the flux of all.
#include "caustics/photons.cl"

// A direction from a diffuse surface; *weight: the cosine's density over that of the choice. Half of the photons go to the
// ball `guide` (w: its radius) where it is small in the sky, half as the surface reflects; weights are those of the two
// together (the balance heuristic of Veach and Guibas 1995), at most 2.
INLINE float3 diffuse_direction(float4 guide, float3 point, float3 facing, float2 u, float *weight) {
    float3 axis = guide.xyz - point;
    float square = dot(axis, axis);
    float sine2 = guide.w * guide.w / square;
    bool guided = guide.w > 0.0f && sine2 < 0.75f;
    bool aimed = false;
    if (guided) {
        aimed = u.x < 0.5f;
        u.x = 2.0f * u.x - (aimed ? 0.0f : 1.0f);
    }
    *weight = 1.0f;
    if (!guided) {
        return around(facing, sqrt(1.0f - u.x), sqrt(u.x), u.y);
    }
    axis *= rsqrt(square);
    float cap = sine2 / (1.0f + sqrt(1.0f - sine2)); // 1 - the cosine of the cone's edge
    float below = u.x * cap;
    float3 direction = aimed ? around(axis, 1.0f - below, sqrt(below * (2.0f - below)), u.y)
                             : around(facing, sqrt(1.0f - u.x), sqrt(u.x), u.y);
    float3 aside = direction - axis;
    bool within = aimed || dot(aside, aside) <= 2.0f * cap;
    float cosine = max(dot(direction, facing), 0.0f);
    *weight = within ? 2.0f * cosine / (cosine + 0.5f / cap) : 2.0f;
    return direction;
}

// Follows a photon to its end. Of its account: `met` is what left the light, what its slot holds, what is the other role's,
// what was absorbed; `lost` what escaped, and what the limits on depth and on bounces cut.
INLINE struct Photon follow_on(__global const struct PhotonFrame *frame, const struct Surfaces *surfaces,
    __global const struct Emitter *emitter, struct Flight *flight, float wavelength, uint index, uint pass, struct Fate *fate) {
    struct Photon photon = no_photon();
    float flux = mean_channel(flight->flux);
    fate->met = (float4)(flux, 0.0f, 0.0f, 0.0f);
    fate->lost = (float4)(0.0f);
    fate->stored = false;
    if (is_dark(flight)) {
        return photon;
    }
    if (emitter->except != 0u && crosses_target(emitter, flight)) {
        fate->met.z = flux;
        return photon;
    }
    uint turns = 0;
    uint bounces = 0;
    uint places = 0;
    for (uint event = 0;; ++event) {
        struct Hit hit;
        if (!surfaces_hit(surfaces, flight->origin, flight->direction, INFINITY, &hit)) {
            fate->lost.x = flux;
            break;
        }
        __global const struct Material *material = surfaces->materials + surfaces->materials_of[hit.surface];
        bool diffuse = material->kind == MATERIAL_DIFFUSE;
        if (event == 0u && diffuse == (emitter->role == ROLE_AFTER_CAUSTIC)) {
            fate->met.z = flux;
            break;
        }
        flight->flux *= body_leaves(surfaces, body_of_stretch(surfaces, flight->within, &hit), hit.t);
        bool cut = false;
        if (diffuse) {
            uint4 counter = (uint4)(index, pass, event, RNG_PHOTON);
            float4 u = uniform_float4(philox4x32(counter, (uint2)(frame->seed_low, frame->seed_high)));
            // The k-th place takes the slot with probability 1 / k.
            places = bounces;
            if (places > 0u && u.x * (float)places < 1.0f) {
                photon.position = (float4)(hit.point, as_float(pack_direction(flight->direction)));
                photon.flux = (float4)(flight->flux, as_float(hit_mark(&hit)));
            }
            float3 albedo = material->color.xyz;
            cut = bounces >= frame->bounces;
            if (cut) {
                flight->flux *= albedo;
            } else {
                float on = min(max(max(albedo.x, albedo.y), albedo.z), 1.0f);
                float3 facing = hit.inside ? -hit.face : hit.face;
                float weight;
                flight->direction = diffuse_direction(frame->guide, hit.point, facing, u.yz, &weight);
                flight->flux *= u.w < on ? weight * albedo / on : (float3)(0.0f);
                flight->origin = hit.point + hit.margin * facing;
                ++bounces;
            }
            fate->lost.z = cut ? mean_channel(flight->flux) : 0.0f;
        } else if (turns < frame->depth) {
            float gained = part_colors(frame, material, wavelength, flight);
            fate->met.x += gained;
            flux += gained;
            turn_photon(surfaces, &hit, material, wavelength, choice_of(frame, flight, index, pass, event), flight);
            ++turns;
        } else {
            cut = true;
            fate->lost.y = mean_channel(flight->flux);
        }
        float left = mean_channel(flight->flux);
        fate->met.w += flux - left;
        flux = left;
        if (cut || is_dark(flight)) {
            break;
        }
    }
    photon.flux.xyz *= (float)places;
    fate->stored = places > 0u;
    fate->met.y = mean_channel(photon.flux.xyz);
    return photon;
}

// As photons_trace, for photons of the other roles, with accounts of their own.
__kernel void photons_bounce(__global const struct PhotonFrame *frame, __global const struct Emitter *emitters,
    __global const struct Shape *shapes, __global const struct Node *nodes, __global const struct Ball *balls,
    __global const float4 *normals, __global const uint *materials_of, __global const struct Material *materials,
    __global struct Photon *photons, __global struct PhotonAccount *accounts, uint account_count, uint pass,
    uint first, uint count) {
    uint item = get_global_id(0);
    if (item >= count) {
        return;
    }
    uint index = first + item;
    struct Surfaces surfaces = {
        shapes, frame->plane_count, nodes, frame->node_count, balls, normals, materials_of, materials};
    float wavelength;
    struct Flight flight = depart(frame, emitters, &surfaces, index, pass, &wavelength);
    __global const struct Emitter *emitter = emitter_of(frame, emitters, index);
    struct Fate fate;
    photons[index] = follow_on(frame, &surfaces, emitter, &flight, wavelength, index, pass, &fate);
    settle(&accounts[index % account_count], &fate);
}
