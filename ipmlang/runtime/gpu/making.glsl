// What a thread makes: records of shapes, and terminals.

void put(uint row, uint word, uint rows, uint value, bool back) {
    if (back) returned[word * rows + row] = value;
    else next[word * rows + row] = value;
}

// One of the two words of a number.
uint half_of(double value, uint which) {
    uvec2 words = unpackDouble2x32(value);
    return (which & 1u) == 0u ? words.x : words.y;
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

// Every access to a buffer costs where it is not taken, too, on some devices: so there is one, in a
// loop over words, and what it writes is worked out.
uint record_word(uint word) {
    switch (word) {
    case HEADER_ENTRY: return record.entry;
    case HEADER_GENERATION: return record.generation;
    case HEADER_KEY0: return record.key.x;
    case HEADER_KEY1: return record.key.y;
    case HEADER_RULE: return record.rule;
    case HEADER_PARENT: return node;
    case HEADER_COPY: return copy_number;
    case HEADER_SEQUENCE: return sequence;
    case HEADER_COUNT: return record.many;
    }
    uint place = (word - HEADER) / 2u;
    uint own = place - state_size;
    uint from = place < state_size ? place
        : record.list == NONE ? record.first + own : code[record.list + own];
    return half_of(r[from], word - HEADER);
}

// It stands at the end of the next queue, or of the table for the CPU. False: there is no room.
bool append() {
    bool back = record.back;
    uint row = atomicAdd(counts[back ? COUNT_RETURNED : COUNT_RECORDS], 1u);
    if (back) row += returned_first;
    else {  // copies are shapes that are yet to be made
        uint before = atomicAdd(counts[COUNT_COPIES], record.many);
        if (record.many > most_shapes || before > most_shapes - record.many) trouble(TROUBLE_LIMIT);
    }
    uint rows = back ? returned_rows : next_rows;
    if (row >= rows) return false;
    uint words = HEADER + 2u * (state_size + record.parameters);
    for (uint word = 0u; word < words; word++) put(row, word, rows, record_word(word), back);
    sequence++;
    return true;
}

// Draw a terminal; false where the table is full.
bool draw(int asset, uint symbol, uint kind, dvec3 given) {
    if (!shown) return true;
    dvec3 size = dvec3(0.0lf);
    if (kind == 1u) size = given;
    if (asset == -3 && slot_geometry != NONE) {
        size = extents;
        if (geometry == 0.0lf) {
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
    uint words = TERMINAL + 6u + 2u * state_size;
    for (uint word = 0u; word < words; word++) {
        uint value = node;
        if (word == TERMINAL_COPY) value = copy_number;
        if (word == TERMINAL_SEQUENCE) value = sequence;
        if (word == TERMINAL_SYMBOL) value = symbol;
        if (word == TERMINAL_ASSET) value = uint(asset);
        if (word == TERMINAL_RULE) value = rule;
        if (word == TERMINAL_KEY0) value = key.x;
        if (word == TERMINAL_KEY1) value = key.y;
        uint axis = (word - TERMINAL) / 2u;
        if (word >= TERMINAL + 6u) value = half_of(r[axis - 3u], word - TERMINAL);
        else if (word >= TERMINAL) value = half_of(size[min(axis, 2u)], word - TERMINAL);
        terminals[word * terminal_rows + row] = value;
    }
    sequence++;
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
