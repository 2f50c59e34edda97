// A scene that no flag of a compiler can change, and a hash of what comes of it.
#pragma once
#include <cstdint>
#include <cstring>
#include <vector>

/// Marsaglia's xorshift. It uses integers, so no flag can change the scene.
struct Random {
    std::uint32_t state = 2463534242u;
    /// A multiple of 2^-16 in [low, low + span), exact for integers below 128. Nothing in it rounds, fused or not.
    float next(int low, std::uint32_t span)
    {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        auto const steps = static_cast<std::int32_t>((state >> 8) % (span << 16));
        return static_cast<float>(low * 65536 + steps) * (1.0f / 65536);
    }
};

/// FNV-1a over words.
template <class Item>
unsigned long long hash(std::vector<Item> const& items)
{
    unsigned long long h = 14695981039346656037u;
    for (Item const& item : items) {
        std::uint32_t words[sizeof(Item) / 4];
        std::memcpy(words, &item, sizeof item);
        for (auto const word : words) h = (h ^ word) * 1099511628211u;
    }
    return h;
}

