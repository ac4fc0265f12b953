#version 330
// The light of one pass on all that is seen: the sun and four parts of the sky, each with its
// shadow. Passes are added up; colours are linear, and multiplied with coverage.

in vec2 spot;
in vec3 ray;

uniform sampler2D depths;
uniform sampler2D facings;
uniform sampler2D colors;
uniform sampler2DShadow shadow_0;
uniform sampler2DShadow shadow_1;
uniform sampler2DShadow shadow_2;
uniform sampler2DShadow shadow_3;
uniform sampler2DShadow shadow_4;
uniform vec3 eye;
uniform vec2 planes;       // how a depth becomes a distance along the view
uniform mat4 into_shadow[5];
uniform vec3 direction[5];
uniform vec3 sun_light;
uniform vec3 sky_light;
uniform vec4 sky_share;
uniform float texel[5];  // the size of a shadow's pixel in the world
uniform vec3 bounce;
uniform vec3 open_ground;
uniform float fade;      // where the ground begins to forget its shadows
uniform float share;     // 1 over the number of passes

out vec4 result;

const int NOTHING = 0, GROUND = 2, INK = 3;

vec3 linear(vec3 color) {
    return mix(color / 12.92, pow((color + 0.055) / 1.055, vec3(2.4)), step(0.04045, color));
}

// How much of a light reaches a point: 0 for one behind the surface, which needs no look.
float open_to(int number, sampler2DShadow shadow, vec3 point, vec3 normal, float slope) {
    if (slope <= 0.0) return 0.0;
    // A step off the surface, longer the more the light grazes it, keeps it from shading itself.
    float away = texel[number] * (0.6 + 1.6 * sqrt(1.0 - min(slope * slope, 1.0)));
    vec3 seen = (into_shadow[number] * vec4(point + normal * away, 1.0)).xyz * 0.5 + 0.5;
    return textureLod(shadow, vec3(seen.xy, min(seen.z, 1.0)), 0.0);
}

void main() {
    vec4 facing = textureLod(facings, spot, 0.0);
    int kind = int(facing.w * 3.0 + 0.5);
    if (kind == NOTHING) {
        result = vec4(0.0);
        return;
    }
    vec3 color = linear(textureLod(colors, spot, 0.0).rgb);
    if (kind == INK) {
        result = vec4(color, 1.0) * share;
        return;
    }
    float depth = textureLod(depths, spot, 0.0).r;
    vec3 point = eye + ray * (planes.x / (planes.y - depth));
    vec3 normal = normalize(facing.xyz * 2.0 - 1.0);
    float slope = dot(normal, direction[0]);
    vec4 slopes = vec4(dot(normal, direction[1]), dot(normal, direction[2]),
                       dot(normal, direction[3]), dot(normal, direction[4]));
    float sun = open_to(0, shadow_0, point, normal, slope);
    vec4 open = vec4(open_to(1, shadow_1, point, normal, slopes.x),
                     open_to(2, shadow_2, point, normal, slopes.y),
                     open_to(3, shadow_3, point, normal, slopes.z),
                     open_to(4, shadow_4, point, normal, slopes.w));
    vec3 got = sun_light * (sun * slope) + sky_light * dot(open * slopes, sky_share);
    if (kind == GROUND) {
        const vec3 brightness = vec3(0.3, 0.6, 0.1);
        float left = dot(got, brightness) / dot(open_ground, brightness);
        float far = smoothstep(fade, fade * 2.2, length(point.xy));
        result = vec4(vec3(0.0), 0.86 * (1.0 - left) * (1.0 - far)) * share;
        return;
    }
    got += bounce * (0.62 - 0.38 * normal.z) * (0.35 + 0.18 * dot(open, vec4(1.0)));
    result = vec4(color * got, 1.0) * share;
}
