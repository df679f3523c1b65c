/* gazebo::math, for plugins of Gazebo 7 and before: -DGAZEBO_MAJOR_VERSION=7. License: Apache License 2.0. */
#ifndef LIBGZ_OLD_MATH_HH
#define LIBGZ_OLD_MATH_HH
#include "gazebo/libgz/base.hh"

#define GZ_DBL_MAX std::numeric_limits<double>::max()
#define GZ_DBL_MIN std::numeric_limits<double>::min()
#define GZ_FLT_MAX std::numeric_limits<float>::max()
#define GZ_FLT_MIN std::numeric_limits<float>::min()
#define GZ_INT32_MAX std::numeric_limits<int32_t>::max()
#define GZ_UINT32_MAX std::numeric_limits<uint32_t>::max()

namespace gazebo {
namespace math {
namespace ign = ignition::math;

template <typename T>
inline T clamp(T value, T low, T high)
{
  return std::max(std::min(value, high), low);
}
template <typename T>
inline bool isnan(T value)
{
  return std::isnan(value);
}
template <typename T>
inline bool equal(const T &a, const T &b, const T &tolerance = T(1e-6))
{
  return std::fabs(a - b) <= tolerance;
}
inline double fixnan(double value) { return std::isfinite(value) ? value : 0.0; }
template <typename T>
inline T precision(const T &value, const unsigned int &digits)
{
  const double scale = std::pow(10, digits);
  return std::round(value * scale) / scale;
}
inline int parseInt(const std::string &text) { return std::atoi(text.c_str()); }
inline double parseFloat(const std::string &text) { return std::atof(text.c_str()); }
inline bool isPowerOfTwo(unsigned int x) { return x != 0 && (x & (x - 1)) == 0; }
template <typename T>
inline T mean(const std::vector<T> &values)
{
  T sum = 0;
  for (const T &value : values)
    sum += value;
  return values.empty() ? sum : sum / values.size();
}

class Angle
{
 public:
  Angle() : value(0) {}
  Angle(double radian) : value(radian) {}
  Angle(const ign::Angle &a) : value(a.Radian()) {}
  operator ign::Angle() const { return ign::Angle(this->value); }
  ign::Angle Ign() const { return *this; }
  void SetFromRadian(double radian) { this->value = radian; }
  void SetFromDegree(double degree) { this->value = degree * M_PI / 180.0; }
  double Radian() const { return this->value; }
  double Degree() const { return this->value * 180.0 / M_PI; }
  double GetAsRadian() const { return this->value; }
  double GetAsDegree() const { return this->Degree(); }
  void Normalize() { this->value = std::atan2(std::sin(this->value), std::cos(this->value)); }
  double operator*() const { return this->value; }
  Angle operator-(const Angle &a) const { return this->value - a.value; }
  Angle operator+(const Angle &a) const { return this->value + a.value; }
  Angle operator*(const Angle &a) const { return this->value * a.value; }
  Angle operator/(const Angle &a) const { return this->value / a.value; }
  Angle operator-() const { return -this->value; }
  Angle &operator-=(const Angle &a) { return *this = *this - a; }
  Angle &operator+=(const Angle &a) { return *this = *this + a; }
  bool operator==(const Angle &a) const { return equal(this->value, a.value, 0.001); }
  bool operator!=(const Angle &a) const { return !(*this == a); }
  bool operator<(const Angle &a) const { return this->value < a.value; }
  bool operator<=(const Angle &a) const { return this->value <= a.value; }
  bool operator>(const Angle &a) const { return this->value > a.value; }
  bool operator>=(const Angle &a) const { return this->value >= a.value; }
  friend std::ostream &operator<<(std::ostream &out, const Angle &a) { return out << a.value; }
  friend std::istream &operator>>(std::istream &in, Angle &a) { return in >> a.value; }

 private:
  double value;
};

class Vector2d
{
 public:
  Vector2d(double x = 0, double y = 0) : x(x), y(y) {}
  Vector2d(const ign::Vector2d &v) : x(v.X()), y(v.Y()) {}
  operator ign::Vector2d() const { return ign::Vector2d(this->x, this->y); }
  ign::Vector2d Ign() const { return *this; }
  double Distance(const Vector2d &v) const { return std::hypot(this->x - v.x, this->y - v.y); }
  void Set(double a, double b) { *this = Vector2d(a, b); }
  Vector2d operator+(const Vector2d &v) const { return {this->x + v.x, this->y + v.y}; }
  Vector2d operator-(const Vector2d &v) const { return {this->x - v.x, this->y - v.y}; }
  Vector2d operator*(double f) const { return {this->x * f, this->y * f}; }
  Vector2d operator/(double f) const { return {this->x / f, this->y / f}; }
  friend std::ostream &operator<<(std::ostream &out, const Vector2d &v) { return out << v.x << " " << v.y; }
  friend std::istream &operator>>(std::istream &in, Vector2d &v) { return in >> v.x >> v.y; }
  double x, y;
};
typedef ign::Vector2i Vector2i;

class Vector3
{
 public:
  static const Vector3 Zero, One, UnitX, UnitY, UnitZ;
  Vector3() : x(0), y(0), z(0) {}
  Vector3(const double &x, const double &y, const double &z) : x(x), y(y), z(z) {}
  Vector3(const Vector3 &v) = default;
  Vector3(const ign::Vector3d &v) : x(v.X()), y(v.Y()), z(v.Z()) {}
  operator ign::Vector3d() const { return ign::Vector3d(this->x, this->y, this->z); }
  ign::Vector3d Ign() const { return *this; }
  double GetSum() const { return this->x + this->y + this->z; }
  double GetLength() const { return std::sqrt(this->GetSquaredLength()); }
  double GetSquaredLength() const { return this->Dot(*this); }
  double Distance(const Vector3 &v) const { return (*this - v).GetLength(); }
  double Distance(double a, double b, double c) const { return this->Distance(Vector3(a, b, c)); }
  Vector3 Normalize() { return *this = this->Normalized(); }
  Vector3 Normalized() const
  {
    const double length = this->GetLength();
    return length > 0 ? *this / length : *this;
  }
  Vector3 Round() { return *this = this->GetRounded(); }
  Vector3 GetRounded() const { return {std::nearbyint(this->x), std::nearbyint(this->y), std::nearbyint(this->z)}; }
  void Set(double a = 0, double b = 0, double c = 0) { *this = Vector3(a, b, c); }
  Vector3 Cross(const Vector3 &v) const
  {
    return {this->y * v.z - this->z * v.y, this->z * v.x - this->x * v.z, this->x * v.y - this->y * v.x};
  }
  double Dot(const Vector3 &v) const { return this->x * v.x + this->y * v.y + this->z * v.z; }
  Vector3 GetAbs() const { return {std::fabs(this->x), std::fabs(this->y), std::fabs(this->z)}; }
  Vector3 GetPerpendicular() const { return this->Ign().Perpendicular(); }
  static Vector3 GetNormal(const Vector3 &a, const Vector3 &b, const Vector3 &c)
  {
    return (b - a).Cross(c - a).Normalized();
  }
  void SetToMax(const Vector3 &v) { *this = {std::max(this->x, v.x), std::max(this->y, v.y), std::max(this->z, v.z)}; }
  void SetToMin(const Vector3 &v) { *this = {std::min(this->x, v.x), std::min(this->y, v.y), std::min(this->z, v.z)}; }
  double GetMax() const { return std::max({this->x, this->y, this->z}); }
  double GetMin() const { return std::min({this->x, this->y, this->z}); }
  bool IsFinite() const { return std::isfinite(this->GetSum()); }
  void Correct() { *this = {fixnan(this->x), fixnan(this->y), fixnan(this->z)}; }
  Vector3 operator+(const Vector3 &v) const { return {this->x + v.x, this->y + v.y, this->z + v.z}; }
  Vector3 operator-(const Vector3 &v) const { return {this->x - v.x, this->y - v.y, this->z - v.z}; }
  Vector3 operator-() const { return {-this->x, -this->y, -this->z}; }
  Vector3 operator*(const Vector3 &v) const { return {this->x * v.x, this->y * v.y, this->z * v.z}; }
  Vector3 operator/(const Vector3 &v) const { return {this->x / v.x, this->y / v.y, this->z / v.z}; }
  Vector3 operator*(double f) const { return {this->x * f, this->y * f, this->z * f}; }
  Vector3 operator/(double f) const { return {this->x / f, this->y / f, this->z / f}; }
  friend Vector3 operator*(double f, const Vector3 &v) { return v * f; }
  Vector3 &operator=(const Vector3 &v) = default;
  Vector3 &operator=(double v) { return *this = Vector3(v, v, v); }
  const Vector3 &operator+=(const Vector3 &v) { return *this = *this + v; }
  const Vector3 &operator-=(const Vector3 &v) { return *this = *this - v; }
  const Vector3 &operator*=(double f) { return *this = *this * f; }
  const Vector3 &operator/=(double f) { return *this = *this / f; }
  bool operator==(const Vector3 &v) const
  {
    return equal(this->x, v.x, 0.001) && equal(this->y, v.y, 0.001) && equal(this->z, v.z, 0.001);
  }
  bool operator!=(const Vector3 &v) const { return !(*this == v); }
  double operator[](unsigned int i) const { return i == 0 ? this->x : i == 1 ? this->y : this->z; }
  friend std::ostream &operator<<(std::ostream &out, const Vector3 &v)
  {
    return out << v.x << " " << v.y << " " << v.z;
  }
  friend std::istream &operator>>(std::istream &in, Vector3 &v) { return in >> v.x >> v.y >> v.z; }
  double x, y, z;
};
inline const Vector3 Vector3::Zero(0, 0, 0), Vector3::One(1, 1, 1), Vector3::UnitX(1, 0, 0), Vector3::UnitY(0, 1, 0),
    Vector3::UnitZ(0, 0, 1);

class Matrix3;
class Matrix4;

class Quaternion
{
 public:
  Quaternion() : w(1), x(0), y(0), z(0) {}
  Quaternion(const double &w, const double &x, const double &y, const double &z) : w(w), x(x), y(y), z(z) {}
  Quaternion(const double &roll, const double &pitch, const double &yaw) : Quaternion(ign::Quaterniond(roll, pitch, yaw)) {}
  Quaternion(const Vector3 &axis, const double &angle) : Quaternion(ign::Quaterniond(axis.Ign(), angle)) {}
  Quaternion(const Vector3 &rpy) : Quaternion(rpy.x, rpy.y, rpy.z) {}
  Quaternion(const ign::Quaterniond &q) : w(q.W()), x(q.X()), y(q.Y()), z(q.Z()) {}
  operator ign::Quaterniond() const { return ign::Quaterniond(this->w, this->x, this->y, this->z); }
  ign::Quaterniond Ign() const { return *this; }
  void Set(double u, double a, double b, double c) { *this = Quaternion(u, a, b, c); }
  void SetFromAxis(double a, double b, double c, double angle) { *this = Quaternion(Vector3(a, b, c), angle); }
  void SetFromAxis(const Vector3 &axis, double angle) { *this = Quaternion(axis, angle); }
  void SetFromEuler(const Vector3 &rpy) { *this = Quaternion(rpy); }
  void SetFromEuler(double roll, double pitch, double yaw) { *this = Quaternion(roll, pitch, yaw); }
  void SetToIdentity() { *this = Quaternion(); }
  static Quaternion EulerToQuaternion(const Vector3 &rpy) { return Quaternion(rpy); }
  static Quaternion EulerToQuaternion(double roll, double pitch, double yaw) { return {roll, pitch, yaw}; }
  Vector3 GetAsEuler() const { return this->Ign().Euler(); }
  void GetAsAxis(Vector3 &axis, double &angle) const
  {
    ign::Vector3d found;
    this->Ign().ToAxis(found, angle);
    axis = found;
  }
  double GetRoll() const { return this->Ign().Roll(); }
  double GetPitch() const { return this->Ign().Pitch(); }
  double GetYaw() const { return this->Ign().Yaw(); }
  Quaternion GetInverse() const { return this->Ign().Inverse(); }
  void Invert() { *this = this->GetInverse(); }
  Quaternion GetLog() const { return this->Ign().Log(); }
  Quaternion GetExp() const { return this->Ign().Exp(); }
  void Normalize() { *this = this->Ign().Normalized(); }
  Vector3 RotateVector(const Vector3 &v) const { return this->Ign().RotateVector(v); }
  Vector3 RotateVectorReverse(const Vector3 &v) const { return this->Ign().RotateVectorReverse(v); }
  Matrix3 GetAsMatrix3() const;
  Matrix4 GetAsMatrix4() const;
  Vector3 GetXAxis() const { return this->Ign().XAxis(); }
  Vector3 GetYAxis() const { return this->Ign().YAxis(); }
  Vector3 GetZAxis() const { return this->Ign().ZAxis(); }
  double Dot(const Quaternion &q) const { return this->w * q.w + this->x * q.x + this->y * q.y + this->z * q.z; }
  static Quaternion Slerp(double t, const Quaternion &a, const Quaternion &b, bool shortest = false)
  {
    return ign::Quaterniond::Slerp(t, a.Ign(), b.Ign(), shortest);
  }
  bool IsFinite() const { return std::isfinite(this->w + this->x + this->y + this->z); }
  Quaternion operator*(const Quaternion &q) const { return this->Ign() * q.Ign(); }
  Quaternion operator*(double f) const { return {this->w * f, this->x * f, this->y * f, this->z * f}; }
  Vector3 operator*(const Vector3 &v) const { return this->RotateVector(v); }
  Quaternion operator*=(const Quaternion &q) { return *this = *this * q; }
  Quaternion operator+(const Quaternion &q) const { return {this->w + q.w, this->x + q.x, this->y + q.y, this->z + q.z}; }
  Quaternion operator-(const Quaternion &q) const { return {this->w - q.w, this->x - q.x, this->y - q.y, this->z - q.z}; }
  Quaternion operator-() const { return {-this->w, -this->x, -this->y, -this->z}; }
  bool operator==(const Quaternion &q) const { return this->Ign() == q.Ign(); }
  bool operator!=(const Quaternion &q) const { return !(*this == q); }
  friend std::ostream &operator<<(std::ostream &out, const Quaternion &q)
  {
    const Vector3 v = q.GetAsEuler();
    return out << v;
  }
  friend std::istream &operator>>(std::istream &in, Quaternion &q)
  {
    Vector3 rpy;
    in >> rpy;
    q = Quaternion(rpy);
    return in;
  }
  double w, x, y, z;
};

class Pose
{
 public:
  static const Pose Zero;
  Pose() {}
  Pose(const Vector3 &pos, const Quaternion &rot) : pos(pos), rot(rot) {}
  Pose(double x, double y, double z, double roll, double pitch, double yaw) : pos(x, y, z), rot(roll, pitch, yaw) {}
  Pose(const ign::Pose3d &p) : pos(p.Pos()), rot(p.Rot()) {}
  operator ign::Pose3d() const { return ign::Pose3d(this->pos, this->rot); }
  ign::Pose3d Ign() const { return *this; }
  void Set(const Vector3 &p, const Quaternion &r) { *this = Pose(p, r); }
  void Set(const Vector3 &p, const Vector3 &rpy) { *this = Pose(p, Quaternion(rpy)); }
  void Set(double x, double y, double z, double roll, double pitch, double yaw)
  {
    *this = Pose(x, y, z, roll, pitch, yaw);
  }
  bool IsFinite() const { return this->pos.IsFinite() && this->rot.IsFinite(); }
  Pose GetInverse() const { return this->Ign().Inverse(); }
  Vector3 CoordPositionAdd(const Vector3 &v) const { return this->Ign().CoordPositionAdd(v.Ign()); }
  Vector3 CoordPositionAdd(const Pose &p) const { return this->Ign().CoordPositionAdd(p.Ign()); }
  Vector3 CoordPositionSub(const Pose &p) const { return this->Ign().CoordPositionSub(p.Ign()); }
  Quaternion CoordRotationAdd(const Quaternion &q) const { return this->Ign().CoordRotationAdd(q.Ign()); }
  Quaternion CoordRotationSub(const Quaternion &q) const { return this->Ign().CoordRotationSub(q.Ign()); }
  Pose CoordPoseSolve(const Pose &p) const { return this->Ign().CoordPoseSolve(p.Ign()); }
  Pose RotatePositionAboutOrigin(const Quaternion &q) const { return this->Ign().RotatePositionAboutOrigin(q.Ign()); }
  void Reset() { *this = Pose(); }
  void Correct() { this->pos.Correct(); }
  void Round(int) {}
  Pose operator+(const Pose &p) const { return this->Ign() + p.Ign(); }
  Pose operator-(const Pose &p) const { return this->Ign() - p.Ign(); }
  Pose operator-() const { return -this->Ign(); }
  Pose operator*(const Pose &p) const { return Pose(p.CoordPositionAdd(*this), p.rot * this->rot); }
  const Pose &operator+=(const Pose &p) { return *this = *this + p; }
  const Pose &operator-=(const Pose &p) { return *this = *this - p; }
  bool operator==(const Pose &p) const { return this->pos == p.pos && this->rot == p.rot; }
  bool operator!=(const Pose &p) const { return !(*this == p); }
  friend std::ostream &operator<<(std::ostream &out, const Pose &p) { return out << p.pos << " " << p.rot; }
  friend std::istream &operator>>(std::istream &in, Pose &p) { return in >> p.pos >> p.rot; }
  Vector3 pos;
  Quaternion rot;
};
inline const Pose Pose::Zero;

/* Rows of a matrix, for m[row][column]. */
template <typename Matrix>
class Rows : public Matrix
{
 public:
  using Matrix::Matrix;
  Rows() {}
  Rows(const Matrix &m) : Matrix(m) {}
  struct Row
  {
    double &operator[](unsigned int column) const { return (*this->matrix)(this->row, column); }
    Matrix *matrix;
    unsigned int row;
  };
  struct ConstRow
  {
    double operator[](unsigned int column) const { return (*this->matrix)(this->row, column); }
    const Matrix *matrix;
    unsigned int row;
  };
  Row operator[](unsigned int row) { return {this, row}; }
  ConstRow operator[](unsigned int row) const { return {this, row}; }
};

class Matrix3 : public Rows<ign::Matrix3d>
{
 public:
  static const Matrix3 IDENTITY, ZERO;
  using Rows::Rows;
  Matrix3() {}
  Matrix3(const ign::Matrix3d &m) : Rows(m) {}
  ign::Matrix3d Ign() const { return *this; }
  void SetFromAxes(const Vector3 &x, const Vector3 &y, const Vector3 &z) { this->Axes(x.Ign(), y.Ign(), z.Ign()); }
  void SetFromAxis(const Vector3 &axis, double angle) { this->Axis(axis.Ign(), angle); }
  void SetCol(unsigned int column, const Vector3 &v) { this->Col(column, v.Ign()); }
  Matrix3 Inverse() const { return ign::Matrix3d::Inverse(); }
  Matrix3 operator*(const Matrix3 &m) const { return this->Ign() * m.Ign(); }
  Matrix3 operator*(const double &f) const { return this->Ign() * f; }
  Matrix3 operator+(const Matrix3 &m) const { return this->Ign() + m.Ign(); }
  Matrix3 operator-(const Matrix3 &m) const { return this->Ign() - m.Ign(); }
  Vector3 operator*(const Vector3 &v) const { return this->Ign() * v.Ign(); }
};
inline const Matrix3 Matrix3::IDENTITY(ign::Matrix3d::Identity), Matrix3::ZERO(ign::Matrix3d::Zero);

class Matrix4 : public Rows<ign::Matrix4d>
{
 public:
  static const Matrix4 IDENTITY, ZERO;
  using Rows::Rows;
  Matrix4() {}
  Matrix4(const ign::Matrix4d &m) : Rows(m) {}
  ign::Matrix4d Ign() const { return *this; }
  void SetTranslate(const Vector3 &v) { this->SetTranslation(v.Ign()); }
  Vector3 GetTranslation() const { return this->Translation(); }
  Quaternion GetRotation() const { return this->Rotation(); }
  Vector3 GetEulerRotation(bool first = true) const { return this->EulerRotation(first); }
  math::Pose GetAsPose() const { return ign::Matrix4d::Pose(); }
  void SetScale(const Vector3 &v) { this->Scale(v.Ign()); }
  Vector3 TransformAffine(const Vector3 &v) const
  {
    ign::Vector3d found;
    if (!ign::Matrix4d::TransformAffine(v.Ign(), found))
      throw std::domain_error("TransformAffine of a matrix that is not affine");
    return found;
  }
  Matrix4 Inverse() const { return ign::Matrix4d::Inverse(); }
  Matrix4 &operator=(const Matrix3 &m)
  {
    for (unsigned int row = 0; row < 3; ++row)
      for (unsigned int column = 0; column < 3; ++column)
        (*this)(row, column) = m(row, column);
    return *this;
  }
  Matrix4 operator*(const Matrix4 &m) const { return this->Ign() * m.Ign(); }
  Matrix4 operator*(const Matrix3 &m) const
  {
    Matrix4 whole = IDENTITY;
    return *this * (whole = m);
  }
  Vector3 operator*(const Vector3 &v) const { return this->Ign() * v.Ign(); }
};
inline const Matrix4 Matrix4::IDENTITY(ign::Matrix4d::Identity), Matrix4::ZERO(ign::Matrix4d::Zero);
inline Matrix3 Quaternion::GetAsMatrix3() const { return ign::Matrix3d(this->Ign()); }
inline Matrix4 Quaternion::GetAsMatrix4() const { return ign::Matrix4d(this->Ign()); }

/* The plane of the points p with normal . p = d. */
class Plane
{
 public:
  Plane() {}
  Plane(const Vector3 &normal, double offset = 0.0) : normal(normal), d(offset) {}
  Plane(const Vector3 &normal, const Vector2d &size, double offset) : normal(normal), size(size), d(offset) {}
  Plane(const ign::Planed &p) : normal(p.Normal()), size(p.Size()), d(p.Offset()) {}
  ign::Planed Ign() const { return ign::Planed(this->normal.Ign(), this->size.Ign(), this->d); }
  void Set(const Vector3 &n, const Vector2d &s, double offset) { *this = Plane(n, s, offset); }
  double Distance(const Vector3 &origin, const Vector3 &direction) const
  {
    return this->Ign().Distance(origin.Ign(), direction.Ign());
  }
  Vector3 normal;
  Vector2d size;
  double d = 0.0;
};

class Box
{
 public:
  Box() {}
  Box(const Vector3 &a, const Vector3 &b) : min(a), max(a)
  {
    this->min.SetToMin(b);
    this->max.SetToMax(b);
  }
  Box(const ign::AxisAlignedBox &b) : min(b.Min()), max(b.Max()) {}
  operator ign::AxisAlignedBox() const { return ign::AxisAlignedBox(this->min.Ign(), this->max.Ign()); }
  ign::AxisAlignedBox Ign() const { return *this; }
  double GetXLength() const { return this->max.x - this->min.x; }
  double GetYLength() const { return this->max.y - this->min.y; }
  double GetZLength() const { return this->max.z - this->min.z; }
  Vector3 GetSize() const { return this->max - this->min; }
  Vector3 GetCenter() const { return (this->min + this->max) * 0.5; }
  bool Contains(const Vector3 &p) const { return this->Ign().Contains(p.Ign()); }
  Vector3 min, max;
};

class Rand
{
 public:
  static void SetSeed(uint32_t seed) { ign::Rand::Seed(seed); }
  static uint32_t GetSeed() { return ign::Rand::Seed(); }
  static double GetDblUniform(double low = 0, double high = 1) { return ign::Rand::DblUniform(low, high); }
  static double GetDblNormal(double mean = 0, double sigma = 1) { return ign::Rand::DblNormal(mean, sigma); }
  static int GetIntUniform(int low, int high) { return ign::Rand::IntUniform(low, high); }
  static int GetIntNormal(int mean, int sigma) { return ign::Rand::IntNormal(mean, sigma); }
};
}  // namespace math
}  // namespace gazebo

namespace libgz {
/* A result under an old name: values of ignition become those of gazebo::math, all others stay. */
inline gazebo::math::Vector3 old(const ignition::math::Vector3d &v) { return v; }
inline gazebo::math::Vector2d old(const ignition::math::Vector2d &v) { return v; }
inline gazebo::math::Quaternion old(const ignition::math::Quaterniond &v) { return v; }
inline gazebo::math::Pose old(const ignition::math::Pose3d &v) { return v; }
inline gazebo::math::Angle old(const ignition::math::Angle &v) { return v; }
inline gazebo::math::Box old(const ignition::math::AxisAlignedBox &v) { return v; }
template <typename T>
inline T old(T value)
{
  return value;
}
}  // namespace libgz

// sdformat reads elements as the types that it knows.
namespace sdf {
inline namespace SDF_VERSION_NAMESPACE {
#define LIBGZ_READ(own, type) \
  template <> \
  inline gazebo::math::own Element::Get<gazebo::math::own>(const std::string &key) const \
  { \
    return this->Get<ignition::math::type>(key); \
  } \
  template <> \
  inline std::pair<gazebo::math::own, bool> Element::Get<gazebo::math::own>( \
      const std::string &key, const gazebo::math::own &otherwise) const \
  { \
    const auto found = this->Get<ignition::math::type>(key, otherwise.Ign()); \
    return {found.first, found.second}; \
  }
LIBGZ_READ(Vector3, Vector3d)
LIBGZ_READ(Vector2d, Vector2d)
LIBGZ_READ(Quaternion, Quaterniond)
LIBGZ_READ(Pose, Pose3d)
LIBGZ_READ(Angle, Angle)
#undef LIBGZ_READ
}  // namespace SDF_VERSION_NAMESPACE
}  // namespace sdf
#endif
