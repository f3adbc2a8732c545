#include "core/archive.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/random.h"

namespace backsight {

enum class Shade { kLight, kDark };

struct Leaf {
  std::string name;
  Shade shade = Shade::kLight;
  bool operator==(const Leaf&) const = default;
};

struct Tree {
  std::vector<Leaf> leaves;
  std::vector<bool> alive;
  std::vector<std::pair<int, double>> rings;
  std::optional<Leaf> fruit;
  std::optional<int> nothing;
  std::array<float, 3> place{};
  Eigen::MatrixXd bark;
  Eigen::VectorXd heights;
  RigidTransform pose;
  std::vector<std::uint64_t> counts;
};

template <class Archive>
void Transfer(Archive& archive, Leaf& leaf) {
  archive(leaf.name, leaf.shade);
}

template <class Archive>
void Transfer(Archive& archive, Tree& tree) {
  archive(tree.leaves, tree.alive, tree.rings, tree.fruit, tree.nothing, tree.place, tree.bark,
          tree.heights, tree.pose, tree.counts);
}

namespace {

Tree MakeTree(std::uint64_t seed) {
  Random random(seed);
  Tree tree;
  tree.leaves = {
      {"oak", Shade::kDark}, {std::string("a\0b", 3), Shade::kLight}, {"", Shade::kDark}};
  tree.alive = {true, false, false, true, true, false, true, true, false};
  tree.rings = {{-3, random.Uniform(-1.0, 1.0)}, {7, std::numeric_limits<double>::denorm_min()}};
  tree.fruit = Leaf{"acorn", Shade::kDark};
  tree.place = {1.5F, -0.0F, 3.25F};
  tree.bark = Eigen::MatrixXd(3, 5);
  for (double& value : tree.bark.reshaped()) value = random.Uniform(-1e9, 1e9);
  tree.heights = tree.bark.col(2);
  tree.pose = {ExpSo3({0.1, 0.2, random.Uniform(0.0, 1.0)}), {1.0, 2.0, 3.0}};
  tree.counts = {0, ~std::uint64_t{0}};
  return tree;
}

TEST(Archive, GivesBackExactlyWhatWasWritten) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Tree tree = MakeTree(seed);
    const std::string bytes = ToBytes(tree);
    const Tree back = FromBytes<Tree>(bytes);
    EXPECT_EQ(back.leaves, tree.leaves);
    EXPECT_EQ(back.alive, tree.alive);
    EXPECT_EQ(back.rings, tree.rings);
    EXPECT_EQ(back.fruit, tree.fruit);
    EXPECT_FALSE(back.nothing);
    EXPECT_EQ(back.place, tree.place);
    EXPECT_EQ(back.bark, tree.bark);
    EXPECT_EQ(back.heights, tree.heights);
    EXPECT_EQ(back.pose.rotation, tree.pose.rotation);
    EXPECT_EQ(back.pose.translation, tree.pose.translation);
    EXPECT_EQ(back.counts, tree.counts);
    EXPECT_EQ(ToBytes(back), bytes);
  }
}

TEST(Archive, PiecesMakeUpTheBytes) {
  std::pair<std::vector<double>, std::vector<Eigen::Vector3f>> value;  // 3.2 MB at once, 2.4 singly
  for (int i = 0; i < 400000; ++i) value.first.push_back(0.1 * i);
  for (int i = 0; i < 200000; ++i) value.second.emplace_back(i, 2 * i, 0.5F);
  std::string joined;
  std::size_t uncopied = 0;
  PutBytes(value, [&](std::string_view piece) {
    joined += piece;
    if (piece.data() == reinterpret_cast<const char*>(value.first.data())) {
      ++uncopied;
    } else {
      EXPECT_LE(piece.size(), std::size_t{1} << 16U);
    }
  });
  EXPECT_EQ(uncopied, 1U);
  EXPECT_EQ(joined.size(), SizeInBytes(value));
  EXPECT_EQ(joined, ToBytes(value));
}

TEST(Archive, PiecesOfEveryKindOfFieldMakeUpTheBytes) {
  const Tree tree = MakeTree(3);
  std::string joined;
  PutBytes(tree, [&](std::string_view piece) { joined += piece; });
  EXPECT_EQ(joined, ToBytes(tree));
}

TEST(Archive, KeepsNanAsItIs) {
  const std::vector<Eigen::Vector3f> normals = {
      Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())};
  const auto back = FromBytes<std::vector<Eigen::Vector3f>>(ToBytes(normals));
  ASSERT_EQ(back.size(), 1U);
  EXPECT_TRUE(back.front().array().isNaN().all());
}

TEST(Archive, OverwritesWhatTheValueHeld) {
  Tree tree = MakeTree(1);
  const std::string bytes = ToBytes(Tree());
  ArchiveReader reader(bytes);
  Transfer(reader, tree);
  EXPECT_EQ(ToBytes(tree), bytes);
}

TEST(Archive, RefusesEveryTruncationAndWhatFollows) {
  const std::string bytes = ToBytes(MakeTree(2));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(FromBytes<Tree>(std::string_view(bytes).substr(0, size)), DamagedArchive) << size;
  }
  EXPECT_THROW(FromBytes<Tree>(bytes + "x"), DamagedArchive);
}

TEST(Archive, HugeCountsAskForNoMemory) {
  std::string bytes = ToBytes(std::vector<double>{1.0});
  for (const int byte : {0, 3, 7}) {
    std::string damaged = bytes;
    damaged[static_cast<std::size_t>(byte)] = static_cast<char>(0x7F);
    EXPECT_THROW(FromBytes<std::vector<double>>(damaged), DamagedArchive);
  }
  const std::uint64_t sides[2] = {std::uint64_t{1} << 33U, std::uint64_t{1} << 33U};
  std::string matrix(reinterpret_cast<const char*>(sides), sizeof(sides));
  matrix.append(1000, '\0');
  EXPECT_THROW(FromBytes<Eigen::MatrixXd>(matrix), DamagedArchive);
}

}  // namespace
}  // namespace backsight
