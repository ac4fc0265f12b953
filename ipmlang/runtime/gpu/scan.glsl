// Prefix sums: each work group sums a block of SCAN_BLOCK numbers, SCAN_EACH a thread, and notes the
// block's total; totals are scanned in the same way and added to their blocks. Sums are modulo 2^32.

layout(local_size_x = SCAN_THREADS) in;

layout(std430, binding = 0) readonly buffer Source { uint source[]; };
layout(std430, binding = 1) buffer Sums { uint sums[]; };
layout(std430, binding = 2) buffer Totals { uint totals[]; };

uniform uint first;   // of the source
uniform uint count;
uniform uint adding;  // 1: totals are added to the sums of their blocks

shared uint parts[SCAN_THREADS];

void add(uint begin, uint end, uint total) {
    for (uint place = begin; place < end; place++) sums[place] += total;
}

void main() {
    uint block = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint own = gl_LocalInvocationID.x;
    uint begin = min(block * SCAN_BLOCK + own * SCAN_EACH, count);
    uint end = min(begin + SCAN_EACH, count);
    if (adding != 0u) {
        if (begin < end) add(begin, end, totals[block]);
        return;
    }
    uint sum = 0u;
    for (uint place = begin; place < end; place++) sum += source[first + place];
    parts[own] = sum;
    barrier();
    for (uint reach = 1u; reach < SCAN_THREADS; reach *= 2u) {
        uint before = own >= reach ? parts[own - reach] : 0u;
        barrier();
        parts[own] += before;
        barrier();
    }
    uint running = parts[own] - sum;
    for (uint place = begin; place < end; place++) {
        sums[place] = running;
        running += source[first + place];
    }
    if (own == SCAN_THREADS - 1u && block * SCAN_BLOCK < count) totals[block] = parts[own];
}
