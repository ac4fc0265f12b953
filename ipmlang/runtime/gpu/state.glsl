// One thread runs one shape: it chooses a production and interprets its bytecode. What it makes goes
// to the end of the next queue, what it draws to the end of the table of terminals, both in any
// order: each row says where in the derivation it stands.

layout(local_size_x = GROUP) in;

layout(std430, binding = 0) readonly buffer Code { uint code[]; };
layout(std430, binding = 1) readonly buffer Data { double data[]; };
layout(std430, binding = 2) readonly buffer Queue { uint queue[]; };
layout(std430, binding = 3) buffer Next { uint next[]; };
layout(std430, binding = 4) buffer Terminals { uint terminals[]; };
layout(std430, binding = 5) buffer Returned { uint returned[]; };
layout(std430, binding = 6) buffer Counts { uint counts[]; };
#ifdef PER_SEED
layout(std430, binding = 7) buffer Stack { uint stack[]; };
#else
layout(std430, binding = 7) readonly buffer Offsets { uint offsets[]; };
#endif

uniform uint records;         // in the queue
uniform uint queue_rows;      // for which there is room, in each table
uniform uint next_rows;
uniform uint terminal_first;  // rows of the table that are filled already
uniform uint terminal_rows;
uniform uint returned_first;
uniform uint returned_rows;
uniform uint first_record;    // the number of the first record, in all of the run
uniform uint first_thread;
uniform uint threads;
uniform uint whole;           // 1: every record is one copy, and `offsets` is not read
uniform uint symbols;         // where in the code their entries begin
uniform uint blocks;          // and those of blocks: code, and the register of the copy's number
uniform uint productions;     // the number of them
uniform uint geometries;      // how many are described, from data[geometry_base] on
uniform uint geometry_base;
uniform uint steps;           // generations that are rewritten; NONE: all
uniform uint state_size;
uniform uint param_size;      // of a record
uniform uint planar;          // 1: the state is x, y, angle
uniform uint slot_scale;      // registers of fields that may not be there; NONE
uniform uint slot_size;
uniform uint slot_geometry;
uniform uint mirrors;
uniform uint budget;          // instructions that a thread may run at once
uniform uint most_shapes;     // in all, with what was made before
uniform uint most_terminals;  // of one dispatch
uniform uint most_generations;
uniform uint resumable;       // 1: it may leave off before any key is made
#ifdef PER_SEED
uniform uint stack_slots;     // frames that each thread has room for, and one more
uniform uint frame_words;
uniform uint registers;       // that a frame keeps, those of the state left out
uniform uint forks;           // 1: what a child does to the state ends with it
uniform uint resuming;        // 1: threads go on where they stopped
#endif

double r[REGISTERS + 64];     // the last ones are for arguments on their way
uvec2 own_key;    // of the shape
uvec2 key;        // under construction
uint rule;        // the production that is applied, NONE: the axiom
uint blamed;      // for trouble: that production, or the symbol where none is applied yet
uint following;   // the generation of what it makes
uint node;        // the record, among all of the run
uint copy_number; // of the copy of it that this thread runs
uint sequence;    // how much this thread has made
bool shown;
bool given_up;

void trouble(uint what) {
    atomicOr(counts[COUNT_TROUBLE], what);
    atomicMin(counts[COUNT_STOPPED], blamed);
    given_up = true;
}

void count_shape() {
    if (atomicAdd(counts[COUNT_SHAPES], 1u) >= most_shapes) trouble(TROUBLE_LIMIT);
}
