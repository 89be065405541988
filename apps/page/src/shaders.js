// A face of degree 2 by its corners p and the offsets d of its edges' nodes from the chords' middles:
// F(b) = sum b_i p_i + 4 sum b_i b_j d_ij, at the places of a lattice of the triangle. So the error is |d|/n^2.

export const vertexShader = (nodal) => `
precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform int axis;       // of the cut; -1: none
uniform float cut, side;
in vec3 position;       // barycentric
in vec3 p0, p1, p2, d0, d1, d2;
in vec4 front, back;    // keys of the elements; w: 1 if there is one and its group is drawn
${nodal ? "in vec3 atCorners, atEdges;" : "in vec2 values;"}
out vec3 place, normal;
out float value;

bool kept(vec4 key) { return key.w > 0.5 && (axis < 0 || (side > 0.0 ? key[axis] <= cut : key[axis] > cut)); }

void main() {
    bool before = kept(front), behind = kept(back);
    if (before == behind) {  // inside of what is kept, or of what is not
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    vec3 b = position;
    vec3 t0 = p0 + 4.0 * (b.y * d0 + b.z * d2);
    vec3 t1 = p1 + 4.0 * (b.x * d0 + b.z * d1);
    vec3 t2 = p2 + 4.0 * (b.y * d1 + b.x * d2);
    vec3 point = b.x * p0 + b.y * p1 + b.z * p2 + 4.0 * (b.x * b.y * d0 + b.y * b.z * d1 + b.z * b.x * d2);
    normal = mat3(modelViewMatrix) * cross(t1 - t0, t2 - t0);
    place = b;
    ${
      nodal
        ? `value = dot(b * (2.0 * b - 1.0), atCorners) + 4.0 * dot(b * b.yzx, atEdges);`
        : `value = before ? values.x : values.y;`
    }
    gl_Position = projectionMatrix * modelViewMatrix * vec4(point, 1.0);
}
`;

export const fragmentShader = `
precision highp float;
uniform sampler2D palette;
uniform vec2 range;          // of the values, of their logarithms where the scale is so
uniform bool logarithmic, plain, ghost, flatLight;
uniform float badBelow;      // values up to here are of bad elements
uniform vec3 badColour, plainColour, lineColour;
uniform vec3 inkColour;      // of what is seen through: that of the page's text
uniform float lines;         // their width in pixels; 0: none
in vec3 place, normal;
in float value;
out vec4 colour;

vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }

vec3 surfaceColour() {
    if (plain) return linear(plainColour);
    if (value <= badBelow) return linear(badColour);
    if (!(abs(value) < 1e38)) return vec3(0.4);
    float v = logarithmic ? log(value) : value;
    float t = range.y > range.x ? (v - range.x) / (range.y - range.x) : 0.5;
    return linear(texture(palette, vec2(clamp(t, 0.0, 1.0), 0.5)).rgb);
}

/// Two lamps that go with the eye, and a little of the sky.
vec3 lit(vec3 c) {
    if (flatLight) return c;
    vec3 n = normalize(normal);
    if (n.z < 0.0) n = -n;
    float key = max(dot(n, normalize(vec3(-0.45, 0.65, 0.75))), 0.0);
    float fill = max(dot(n, normalize(vec3(0.8, -0.15, 0.45))), 0.0);
    float gloss = pow(max(dot(n, normalize(vec3(-0.24, 0.35, 0.9))), 0.0), 48.0);
    return c * (0.36 + 0.10 * n.y + 0.68 * key + 0.16 * fill) + 0.04 * gloss;
}

/// How much of the pixel the face's edges cover. They fade where faces are no larger than a few pixels.
float edgeCover() {
    vec3 slope = max(sqrt(dFdx(place) * dFdx(place) + dFdy(place) * dFdy(place)), 1e-12);
    vec3 away = place / slope;               // pixels from each edge
    vec3 cover = 1.0 - smoothstep(0.5 * lines - 0.5, 0.5 * lines + 0.5, away);
    vec3 fade = smoothstep(1.5, 14.0, 1.0 / slope);
    vec3 seen = cover * fade;
    return max(seen.x, max(seen.y, seen.z));
}

void main() {
    vec3 c = lit(surfaceColour());
    float line = lines > 0.0 ? edgeCover() : 0.0;
    if (ghost) {
        colour = vec4(inkColour, 0.04 + 0.38 * line);
        colour.rgb *= colour.a;
        return;
    }
    float dark = 1.0 - smoothstep(0.02, 0.10, dot(c, vec3(0.3, 0.6, 0.1)));  // where a dark line is not seen
    c = mix(c, mix(linear(lineColour), vec3(0.45), dark), (0.72 - 0.35 * dark) * line);
    colour = vec4(pow(c, vec3(1.0 / 2.2)), 1.0);
}
`;
