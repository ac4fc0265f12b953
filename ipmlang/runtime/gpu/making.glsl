// What a thread makes: records of shapes, and terminals.

void put(uint row, uint word, uint rows, uint value, bool back) {
    if (back) returned[word * rows + row] = value;
    else next[word * rows + row] = value;
}

void put_number(uint row, uint word, uint rows, double value, bool back) {
    uvec2 words = unpackDouble2x32(value);
    put(row, word, rows, words.x, back);
    put(row, word + 1u, rows, words.y, back);
}

// The record that an instruction makes: what it is, and which registers its parameters stand in,
// those that a list names, or those from `first` on where the list is NONE.
struct Record {
    uint entry;
    uint generation;
    uvec2 key;
    uint rule;
    uint many;
    uint list;
    uint first;
    uint parameters;
    bool back;  // the CPU derives it
};

Record record;

// It stands at the end of the next queue, or of the table for the CPU. False: there is no room.
bool append() {
    bool back = record.back;
    uint row = atomicAdd(counts[back ? COUNT_RETURNED : COUNT_RECORDS], 1u);
    if (back) row += returned_first;
    else if (atomicAdd(counts[COUNT_COPIES], record.many) + record.many < record.many)
        trouble(TROUBLE_COUNT);
    uint rows = back ? returned_rows : next_rows;
    if (row >= rows) return false;
    put(row, HEADER_ENTRY, rows, record.entry, back);
    put(row, HEADER_GENERATION, rows, record.generation, back);
    put(row, HEADER_KEY0, rows, record.key.x, back);
    put(row, HEADER_KEY1, rows, record.key.y, back);
    put(row, HEADER_RULE, rows, record.rule, back);
    put(row, HEADER_PARENT, rows, node, back);
    put(row, HEADER_COPY, rows, copy_number, back);
    put(row, HEADER_SEQUENCE, rows, sequence, back);
    put(row, HEADER_COUNT, rows, record.many, back);
    for (uint place = 0u; place < state_size + record.parameters; place++) {
        uint own = place - state_size;
        uint from = place < state_size ? place
            : record.list == NONE ? record.first + own : code[record.list + own];
        put_number(row, HEADER + 2u * place, rows, r[from], back);
    }
    sequence++;
    return true;
}

// Draw a terminal; false where the table is full.
bool draw(int asset, uint symbol, uint kind, dvec3 given) {
    if (!shown) return true;
    dvec3 size = dvec3(0.0lf);
    if (kind == 1u) size = given;
    if (asset == -3 && slot_geometry != NONE) {
        size = dvec3(r[slot_size], r[slot_size + 1u], r[slot_size + 2u]);
        if (r[slot_geometry] == 0.0lf) {
            atomicAdd(counts[COUNT_NOTES + productions + 1u + symbol], 1u);
            return true;
        }
    }
    bool sound = is_finite(size.x) && is_finite(size.y) && is_finite(size.z);
    for (uint field = 0u; field < (planar != 0u ? 3u : 7u); field++)
        sound = sound && is_finite(r[field]);
    if (!sound || !is_finite(scale_factor())) {
        trouble(TROUBLE_NOT_FINITE);
        return true;
    }
    uint drawn = atomicAdd(counts[COUNT_TERMINALS], 1u);
    if (drawn >= most_terminals) trouble(TROUBLE_LIMIT);
    uint row = terminal_first + drawn;
    if (row >= terminal_rows) return false;
    uint number = sequence++;
    terminals[TERMINAL_PARENT * terminal_rows + row] = node;
    terminals[TERMINAL_COPY * terminal_rows + row] = copy_number;
    terminals[TERMINAL_SEQUENCE * terminal_rows + row] = number;
    terminals[TERMINAL_SYMBOL * terminal_rows + row] = symbol;
    terminals[TERMINAL_ASSET * terminal_rows + row] = uint(asset);
    terminals[TERMINAL_RULE * terminal_rows + row] = rule;
    terminals[TERMINAL_KEY0 * terminal_rows + row] = key.x;
    terminals[TERMINAL_KEY1 * terminal_rows + row] = key.y;
    for (uint axis = 0u; axis < 3u; axis++) {
        uvec2 words = unpackDouble2x32(size[axis]);
        terminals[(TERMINAL + 2u * axis) * terminal_rows + row] = words.x;
        terminals[(TERMINAL + 2u * axis + 1u) * terminal_rows + row] = words.y;
    }
    for (uint field = 0u; field < state_size; field++) {
        uvec2 words = unpackDouble2x32(r[field]);
        terminals[(TERMINAL + 6u + 2u * field) * terminal_rows + row] = words.x;
        terminals[(TERMINAL + 6u + 2u * field + 1u) * terminal_rows + row] = words.y;
    }
    return true;
}

bool on_cpu(uint symbol) {
    return (code[symbols + symbol * ENTRY + ENTRY_FLAGS] & ON_CPU) != 0u;
}

// A child: nothing can come of a barren symbol, which is counted all the same.
bool worth_making(uint symbol) {
    uint entry = symbols + symbol * ENTRY;
    if (code[entry + ENTRY_MEANING] != NONE) return true;
    if (code[entry + ENTRY_INTERPRETATIONS] != NONE && following < FINAL) return true;
    if (code[entry + ENTRY_PRODUCTIONS] == NONE || following >= FINAL) return false;
    return steps == NONE || following < steps;
}

double copies_of(double limit) {
    if (!is_finite(limit)) {
        if (shown) trouble(TROUBLE_COUNT);
        return 0.0lf;
    }
    double found = ceil(limit - 1e-9lf * max(1.0lf, abs(limit)));
    if (found > double(most_shapes)) trouble(TROUBLE_LIMIT);
    return max(found, 0.0lf);
}
