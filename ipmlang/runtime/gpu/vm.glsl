// The machine: which production is taken, and the loop over its instructions.

double total;    // of the shares so far
double drawn;    // the draw that chooses, less than 0 before it is known
uint taken;      // the alternative; NONE: none yet
uint generation; // of the shape

void share(uint alternative, double part) {
    if (!(part >= 0.0lf)) trouble(TROUBLE_SHARES);
    if (drawn < 0.0lf) {
        uvec2 words = mixed(own_key, CHOICE_SITE ^ SIGN_BIT);
        drawn = draw_of(words);
    }
    total += part;
    if (taken == NONE && drawn < total) taken = alternative;
}

// Where the code of a symbol's shape begins, and the generation of what it makes.
uint entered(uint symbol, uint its_generation) {
    uint entry = symbols + symbol * ENTRY;
    total = 0.0lf;
    drawn = -1.0lf;
    taken = NONE;
    if (its_generation < FINAL) {
        uint begin = code[entry + ENTRY_PRODUCTIONS];
        if (begin != NONE && (steps == NONE || its_generation < steps)) {
            following = its_generation + 1u;
            atomicMax(counts[COUNT_GENERATION], following);
            if (following > most_generations) trouble(TROUBLE_LIMIT);
            return begin;
        }
        begin = code[entry + ENTRY_INTERPRETATIONS];
        if (begin != NONE) {
            following = FINAL;
            return begin;
        }
    }
    key = own_key;
    return code[entry + ENTRY_MEANING];
}

uint spent;     // instructions so far, and words that were moved
bool complete;  // the thread came to an end: some drivers break loops off without a word

#ifdef PER_SEED

// A thread's part of the stack, word by word beside those of the others: how many frames there are
// (NONE: it is done), how much it has made, its state, then frames: where to go on, the rule, the
// generation of what it makes, both keys, whether anything is there, registers, and, where children
// fork, the state.

uint thread_number;
uint depth;
bool absent;  // the whole shape stands in a hole, and nothing that it makes is there

void keep(uint word, uint value) { stack[word * threads + thread_number] = value; }

uint kept(uint word) { return stack[word * threads + thread_number]; }

// A frame is pairs of words: four of its own, then registers, then the state.
void push(uint at, bool with_state) {
    uint frame = 2u + depth * frame_words;
    uint many = 4u + registers + (with_state ? state_size : 0u);
    for (uint place = 0u; place < many; place++) {
        uvec2 pair = uvec2(at, rule);
        if (place == 1u) pair = uvec2(following, (shown ? 1u : 0u) | (absent ? 2u : 0u));
        if (place == 2u) pair = own_key;
        if (place == 3u) pair = key;
        if (place >= 4u) {
            uint own = place - 4u;
            pair = unpackDouble2x32(r[own < registers ? state_size + own : own - registers]);
        }
        keep(frame + 2u * place, pair.x);
        keep(frame + 2u * place + 1u, pair.y);
    }
    depth++;
    spent += many / 8u;
}

uint pop(bool with_state) {
    depth--;
    uint at = 0u;
    uint frame = 2u + depth * frame_words;
    uint many = 4u + registers + (with_state ? state_size : 0u);
    for (uint place = 0u; place < many; place++) {
        uvec2 pair = uvec2(kept(frame + 2u * place), kept(frame + 2u * place + 1u));
        if (place == 0u) {
            at = pair.x;
            rule = pair.y;
        }
        if (place == 1u) {
            following = pair.x;
            shown = (pair.y & 1u) != 0u;
            absent = (pair.y & 2u) != 0u;
        }
        if (place == 2u) own_key = pair;
        if (place == 3u) key = pair;
        uint own = place - 4u;
        if (place >= 4u)
            r[own < registers ? state_size + own : own - registers] = packDouble2x32(pair);
    }
    spent += many / 8u;
    return at;
}

#endif

// What an instruction leaves to be done after it, once for all of them: these parts are long, and a
// compiler writes them out wherever they are called.
const uint DONE = 0u;
const uint MAKE = 1u;     // a record
const uint STOP = 2u;     // leave off; another dispatch goes on
const uint RETURN = 3u;   // the code of the shape has ended
const uint STAY = 4u;     // no production takes the shape
#ifdef PER_SEED
const uint RESUMED = 5u;  // go on where the thread left off
const uint CALL = 6u;     // the child that an instruction makes
#endif

// The thread leaves off before the instruction at a place. Without stacks the rest is a record.
void describe_rest(uint at) {
    record = Record(RESUME | (shown ? 0u : HIDDEN) | at, following, own_key, rule, 1u, NONE,
                    state_size, param_size, false);
}

void run(uint at, uint action) {
    for (;;) {
        uint word = code[at], more = code[at + 1u], z = code[at + 2u], w = code[at + 3u];
        uint target = word >> 8 & 255u, a = word >> 16 & 255u, b = word >> 24;
        uint c = more & 255u, d = more >> 8 & 255u, n = more >> 24;
        moves = false;
        spins = false;
        circles = false;
        spent++;
        uint here = at;
        // what is read and written stands in arrays: once each, whatever the instruction
        double ra = r[a], rb = r[b], rc = r[c];
        double result = 0.0lf;
        bool writes = false;
        reshaped = false;
        if (slot_size != NONE) {
            extents = dvec3(r[slot_size], r[slot_size + 1u], r[slot_size + 2u]);
            geometry = r[slot_geometry];
        }
        if (action == DONE) {
            at += 4u;
            switch (word & 255u) {
            case OP_END:
                action = RETURN;
#ifdef PER_SEED
                if (depth > 0u && spent > budget) action = STOP;  // many calls may end at once
#endif
                break;
            case OP_LOAD:
                result = data[z];
                writes = true;
                break;
            case OP_COPY:
                result = ra;
                writes = true;
                break;
            case OP_CALL: {
                double given[ARGUMENTS];
                given[0] = ra;
                given[1] = rb;
                given[2] = rc;
                result = function_of(z, given);
                writes = true;
                break;
            }
            case OP_PICK: {
                uint place = uint(min(floor(ra * double(n)), double(n - 1u)));
                result = r[code[z + place]];
                writes = true;
                break;
            }
            case OP_KEY:
                if (n != 0u && spent > budget && resumable != 0u) action = STOP;
                else key = z == NONE ? own_key : mixed(own_key, z);
                break;
            case OP_MIX: key = mixed(key, to_word(ra)); break;
            case OP_UNIFORM:
                result = draw_of(key);
                writes = true;
                break;
            case OP_ROW:
                result = data[z + (ra > 0.0lf ? uint(min(ra, double(w - 1u))) : 0u)];
                writes = true;
                break;
            case OP_MOVE: go_by(dvec3(ra, rb, rc)); break;
            case OP_TURN: rotate_by(z, ra); break;
            case OP_ORIENT: orient_by(ra, rb, rc, r[d]); break;
            case OP_SCALE:
                if (!(ra > 0.0lf)) trouble(TROUBLE_FACTOR);
                target = slot_scale;
                result = scale_factor() * ra;
                writes = true;
                break;
            case OP_MIRROR:
                target = slot_scale;
                result = -scale_factor();
                writes = true;
                break;
            case OP_LEVEL: level(); break;
            case OP_SIZE: resize(dvec3(ra, rb, rc)); break;
            case OP_SLAB: if (!slab(z, ra, rb)) at = w; break;
            case OP_ZERO:
                if (is_nan(ra)) trouble(TROUBLE_NOT_FINITE);
                else if (ra == 0.0lf) at = z;
                break;
            case OP_CHECK:
                if ((shown || n != 0u) && !is_finite(ra)) trouble(TROUBLE_NOT_FINITE);
                else if (n == 2u && ra < 0.0lf) trouble(TROUBLE_SHARES);
                break;
#ifdef PER_SEED
            case OP_SHOW: shown = ra != 0.0lf && !absent; break;
#else
            case OP_SHOW: shown = ra != 0.0lf; break;
#endif
            case OP_EMIT:
#ifdef PER_SEED
                if (!draw(int(z), w, n, dvec3(ra, rb, rc))) action = STOP;
#else
                draw(int(z), w, n, dvec3(ra, rb, rc));  // its need is counted to the end
#endif
                break;
            case OP_CHILD:
#ifdef PER_SEED
                // What stands in a hole is not there, but the turtle goes on behind it.
                if (!shown && (forks != 0u || on_cpu(z))) break;
#else
                if (!shown) break;
#endif
                record = Record(z, following, key, rule, 1u, w, 0u, n, on_cpu(z));
#ifdef PER_SEED
                if (record.back) {
                    if (worth_making(z)) action = MAKE;
                } else if (depth >= stack_slots) {
                    atomicMax(counts[COUNT_COPIES], 1u);
                    action = STOP;
                    break;
                } else if (worth_making(z)) {
                    action = CALL;
                }
#else
                if (worth_making(z)) action = MAKE;
#endif
                if (shown) count_shape();
                break;
            case OP_RANGE:
                if (!shown || !(ra > 0.0lf)) break;
                record = Record(BLOCK | z, following, own_key, rule, uint(ra), w, 0u, n, false);
                action = MAKE;
                break;
            case OP_COUNT:
                result = copies_of(ra);
                writes = true;
                break;
            case OP_LOOP:
                result = ra + 1.0lf;
                writes = true;
                target = a;
                if (!(result < rb)) break;
                at = z;
                if (n == 0u && spent > budget) {
                    here = at;
                    action = STOP;
                }
                break;
            case OP_FETCH:
                result = sampled(code[z], ra, rb);
                writes = true;
                break;
            case OP_MEASURE:
                result = measured(z);
                writes = true;
                break;
            case OP_EXTRUDE: extrude(ra, data[z]); break;
            case OP_FACES:
                result = face_count(z);
                writes = true;
                break;
            case OP_FACE: face(z, ra); break;
            case OP_CENTER: center(z, n != 0u); break;
            case OP_FLIP: flip(z); break;
            case OP_RULE: blamed = rule = z; break;
            case OP_SHARE: share(z, ra); break;
            case OP_TAKE:
                if (taken == NONE) taken = z;
                at = w;
                break;
            case OP_CHOOSE:
                if (total > 1.0lf + 1e-9lf) trouble(TROUBLE_SHARES);
                if (taken == NONE) {
                    action = STAY;
                    break;
                }
                at = code[z + 2u * taken];
                blamed = rule = code[z + 2u * taken + 1u];
                break;
            case OP_JUMP: at = z; break;
            case OP_DIFFER:
                result = ra != rb ? 1.0lf : 0.0lf;
                writes = true;
                break;
            default: trouble(TROUBLE_GEOMETRY);
            }
        }
        if (writes) r[target] = result;
        if (reshaped) {
            r[slot_size] = extents.x;
            r[slot_size + 1u] = extents.y;
            r[slot_size + 2u] = extents.z;
            r[slot_geometry] = geometry;
        }
        if (given_up) return;
        if (moves || spins) move_and_spin();
        if (action == DONE) continue;
        if (action == STAY) {  // the shape stays, with a key of its own, or is an error
            if (steps == NONE && following < FINAL) {
                trouble(TROUBLE_NO_PRODUCTION);
                return;
            }
            if (shown) count_shape();
            record = Record(w, following, mixed(own_key, CHOICE_SITE), NONE, 1u, NONE, state_size,
                            code[symbols + w * ENTRY + ENTRY_ARITY], on_cpu(w));
            rule = NONE;
            at = 0u;  // where an END stands
            action = DONE;
            if (worth_making(w)) {
#ifdef PER_SEED
                d = 1u;
                action = record.back ? MAKE : CALL;
#else
                action = MAKE;
#endif
            }
        }
#ifdef PER_SEED
        if (action == MAKE && !append()) {
            atomicAdd(counts[COUNT_SHAPES], NONE);  // it is counted when it is made
            action = STOP;
        } else if (action == MAKE) {
            action = DONE;
        }
        if (action == STOP || (action == CALL && d == 0u))
            push(action == STOP ? here : at, action == STOP || forks != 0u);
        if (action == STOP) {
            keep(0u, depth);
            keep(1u, sequence);
            atomicAdd(counts[COUNT_RECORDS], 1u);
            complete = true;
            return;
        }
        if (action == CALL) {
            absent = !shown;
            own_key = record.key;
            bool sound = true;
            for (uint place = 0u; place < record.parameters; place++) {
                uint from = record.list == NONE ? record.first + place : code[record.list + place];
                r[REGISTERS + place] = r[from];
                sound = sound && is_finite(r[from]);
            }
            for (uint place = 0u; place < record.parameters; place++)
                r[state_size + place] = r[REGISTERS + place];
            if (!sound) {
                trouble(TROUBLE_NOT_FINITE);
                return;
            }
            spent += record.parameters / 4u;
            at = entered(record.entry, following);
            if (at == NONE) at = 0u;
        }
        if (action == RETURN && depth == 0u) {
            keep(0u, NONE);
            complete = true;
            return;
        }
        if (action == RETURN || action == RESUMED) at = pop(action == RESUMED || forks != 0u);
#else
        if (action == STOP) describe_rest(here);
        if (action == MAKE || action == STOP) append();
        if (action == RETURN || action == STOP) {
            complete = true;
            return;
        }
#endif
        action = DONE;
    }
}

double queued(uint record, uint word) {
    return packDouble2x32(uvec2(queue[word * queue_rows + record],
                                queue[(word + 1u) * queue_rows + record]));
}

#ifndef PER_SEED
// The record that a thread runs a copy of: the last one whose copies begin at it or before.
uint record_of(uint thread) {
    uint low = 0u, high = records;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (offsets[middle] <= thread) low = middle;
        else high = middle;
    }
    return low;
}
#endif

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number >= threads) return;
    uint thread = first_thread + number;
#ifdef PER_SEED
    uint record = thread;
    copy_number = 0u;
    thread_number = number;
    depth = 0u;
    absent = false;
    if (resuming != 0u && kept(0u) == NONE) {
        atomicAdd(counts[COUNT_ENDED], 1u);
        return;
    }
#else
    uint record = whole != 0u ? thread : record_of(thread);
    copy_number = whole != 0u ? 0u : thread - offsets[record];
#endif
    uint entry = queue[HEADER_ENTRY * queue_rows + record];
    generation = queue[HEADER_GENERATION * queue_rows + record];
    own_key = uvec2(queue[HEADER_KEY0 * queue_rows + record],
                    queue[HEADER_KEY1 * queue_rows + record]);
    rule = queue[HEADER_RULE * queue_rows + record];
    blamed = entry < BLOCK ? productions + 1u + entry : rule;
    taken = NONE;
    total = 0.0lf;
    node = first_record + record;
    sequence = 0u;
    spent = 0u;
    complete = false;
    shown = true;
    given_up = false;
    for (uint place = 0u; place < state_size + param_size; place++)
        r[place] = queued(record, HEADER + 2u * place);
    uint at;
#ifdef PER_SEED
    uint action = resuming != 0u ? RESUMED : DONE;
    if (resuming != 0u) {
        depth = kept(0u);
        sequence = kept(1u);
        at = 0u;
    } else
#else
    uint action = DONE;
#endif
    if ((entry & RESUME) != 0u) {
        following = generation;
        shown = (entry & HIDDEN) == 0u;
        at = entry & ~(RESUME | HIDDEN);
    } else if ((entry & BLOCK) != 0u) {
        following = generation;
        uint block = blocks + (entry & ~BLOCK) * 2u;
        at = code[block];
        r[code[block + 1u]] = from_word(copy_number);
    } else {
        bool sound = true;
        uint last = state_size + code[symbols + entry * ENTRY + ENTRY_ARITY];
        for (uint place = state_size; place < last; place++) sound = sound && is_finite(r[place]);
        for (uint field = 0u; field < (planar != 0u ? 3u : 7u); field++)
            sound = sound && is_finite(r[field]);
        at = entered(entry, generation);
        if (!sound) trouble(TROUBLE_NOT_FINITE);
    }
#ifdef PER_SEED
    if (at == NONE) keep(0u, NONE);
#endif
    if (at == NONE) complete = true;
    else if (!given_up) run(at, action);
    if (complete) atomicAdd(counts[COUNT_ENDED], 1u);
}
